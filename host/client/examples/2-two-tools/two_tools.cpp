// Example 2: two tools in one message. Both press for half a second; then the second one turns.
//
// `chaincell serve box.chaincell --tool sphere:0.008 --tool box:0.008,0.008,0.002,0.004 --scene left`
// runs meanwhile, of a body of `--young-pa`; then `./two_tools left`.
#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <thread>

#include "chaincell_client.h"

// A second: a device's loop waits for less than a millisecond.
constexpr std::uint64_t WAIT_NS = 1'000'000'000;
// Where the surface of the body is [m].
constexpr double TOP_M = 0.04;

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
    const auto start = std::chrono::steady_clock::now();
    for (int tick = 0; tick < 1000; ++tick) {
        std::this_thread::sleep_until(start + std::chrono::milliseconds(tick));
        const double z_m = TOP_M + 0.003 - 0.005 * std::min(tick / 500.0, 1.0);
        // A turn about x: t is the tangent of a quarter of its angle.
        const double t = 0.05 * std::max(tick / 500.0 - 1.0, 0.0);
        const double sin = 2.0 * t / (1.0 + t * t), cos = (1.0 - t * t) / (1.0 + t * t);
        const bool engaged = tick > 0; // first released
        const chaincell_tool_pose poses[] = {
            {{-0.015F, 0, static_cast<float>(z_m + 0.008)}, {0, 0, 0, 1}, engaged, 0},
            {{0.015F, 0, static_cast<float>(z_m + 0.006)},
             {static_cast<float>(sin), 0, 0, static_cast<float>(cos)},
             engaged, 0}};
        chaincell_client_answer answer;
        code = chaincell_client_step(client, poses, 2, WAIT_NS, &answer);
        if (code < 0) {
            return std::fprintf(stderr, "%s\n", chaincell_client_error_text(code)), 1;
        }
        if (tick % 250 == 249) {
            std::printf("tick %" PRIu64 ": state hash %016" PRIx64 "\n", answer.tick, answer.state_hash);
            for (int number = 0; number < 2; ++number) {
                const float *n = answer.tools[number].force_n;
                std::printf("  tool %d: force %.9f %.9f %.9f N\n", number, n[0], n[1], n[2]);
                const float *n_m = answer.tools[number].torque_n_m;
                std::printf("  tool %d: torque %.9f %.9f %.9f N m\n", number, n_m[0], n_m[1], n_m[2]);
            }
        }
    }
    return chaincell_client_close(client);
}
