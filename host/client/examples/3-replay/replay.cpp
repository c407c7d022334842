// Example 3: plays a file of poses, `tick,x_m,y_m,z_m,engaged` line by line, as `chaincell run` writes
// it.
//
// `chaincell run plane.chaincell --contact 40 --motion press --seconds 2 --out offline` writes
// offline/path.csv, and `chaincell serve plane.chaincell --contact 40 --scene left --record left.trace`
// runs meanwhile; then `./replay left offline/path.csv`.
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include "chaincell_client.h"

// A second: a device's loop waits for less than a millisecond.
constexpr std::uint64_t WAIT_NS = 1'000'000'000;

int main(int count, char **words)
{
    std::ifstream file(count > 2 ? words[2] : "");
    if (!file) {
        return std::fprintf(stderr, "which file?\n"), 1;
    }
    // The tissue's own forces, however late they are. For a device leave both at 20 ms.
    chaincell_client_options options = CHAINCELL_CLIENT_OPTIONS_DEFAULT;
    options.watchdog_ms = options.ramp_ms = 0;
    chaincell_client client;
    chaincell_client_code code = chaincell_client_open(CHAINCELL_CLIENT_VERSION, words[1], &options, &client);
    if (code < 0) {
        return std::fprintf(stderr, "%s\n", chaincell_client_error_text(code)), 1;
    }
    // A tool has no force until a pose has released it once.
    chaincell_tool_pose pose{{0, 0, 0}, {0, 0, 0, 1}, 0, 0};
    chaincell_client_answer answer;
    chaincell_client_step(client, &pose, 1, WAIT_NS, &answer);
    const auto start = std::chrono::steady_clock::now();
    std::string line;
    std::getline(file, line);
    for (int tick = 0; std::getline(file, line); ++tick) {
        std::this_thread::sleep_until(start + std::chrono::milliseconds(tick));
        float *at_m = pose.position_m;
        if (std::sscanf(line.c_str(), "%*u,%f,%f,%f,%" SCNu16, at_m, at_m + 1, at_m + 2, &pose.engaged) != 4) {
            return std::fprintf(stderr, "%s\n", line.c_str()), 1;
        }
        code = chaincell_client_step(client, &pose, 1, WAIT_NS, &answer);
        if (code < 0) {
            return std::fprintf(stderr, "%s\n", chaincell_client_error_text(code)), 1;
        }
        if (tick % 500 == 499) {
            std::printf("row %d: state hash %016" PRIx64 "\n", tick, answer.state_hash);
            const float *n = answer.tools[0].force_n;
            std::printf("  force %.9f %.9f %.9f N\n", n[0], n[1], n[2]);
        }
    }
    return chaincell_client_close(client);
}
