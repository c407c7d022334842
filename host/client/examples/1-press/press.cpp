// Example 1: presses a served tissue for half a second, holds it as long, and lets go.
//
// `chaincell serve plane.chaincell --contact 40 --scene left` runs meanwhile; then `./press left`.
#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cmath>
#include <cstdio>
#include <thread>

#include "chaincell_client.h"

// A second: a device's loop waits for less than a millisecond.
constexpr std::uint64_t WAIT_NS = 1'000'000'000;

int main(int, char **words)
{
    // The tissue's own forces, however late they are. For a device leave both at 20 ms.
    chaincell_client_options options = CHAINCELL_CLIENT_OPTIONS_DEFAULT;
    options.watchdog_ms = options.ramp_ms = 0;
    chaincell_client client;
    chaincell_client_code code = chaincell_client_open(CHAINCELL_CLIENT_VERSION, words[1], &options, &client);
    if (code < 0) {
        return std::fprintf(stderr, "%s\n", chaincell_client_error_text(code)), 1;
    }
    double largest_n = 0.0;
    chaincell_client_answer answer{};
    const auto start = std::chrono::steady_clock::now();
    for (int tick = 0; tick < 1500; ++tick) {
        std::this_thread::sleep_until(start + std::chrono::milliseconds(tick));
        const double depth_m = 0.02 * std::min(tick / 500.0, 1.0);
        // A tool has no force until a pose has released it once.
        const bool engaged = tick > 0 && tick <= 1000;
        const chaincell_tool_pose pose{{0, 0, static_cast<float>(-depth_m)}, {0, 0, 0, 1}, engaged, 0};
        code = chaincell_client_step(client, &pose, 1, WAIT_NS, &answer);
        if (code < 0) {
            return std::fprintf(stderr, "%s\n", chaincell_client_error_text(code)), 1;
        }
        const double x = answer.tools[0].force_n[0]; // what a device shows now
        const double y = answer.tools[0].force_n[1];
        const double z = answer.tools[0].force_n[2];
        largest_n = std::max(largest_n, std::sqrt(x * x + y * y + z * z));
        if (tick == 1000 || tick == 1499) {
            std::printf("tick %" PRIu64 ": state hash %016" PRIx64 "\n", answer.tick, answer.state_hash);
        }
    }
    std::printf("%" PRIu64 " answers, largest force %.9f N\n", answer.answers, largest_n);
    return chaincell_client_close(client);
}
