// Example 4: a Force Dimension device (omega, delta, sigma) on a served tissue, by the DHD interface of its SDK.
//
// `chaincell serve liver.chaincell --tool sphere:0.012 --device omega --scene left` runs meanwhile; then
// `./force_dimension left [X Y Z]`, the position of the device's zero in the scene [m]. The device's button or Ctrl-C
// ends it. Its axes are x to the user, y to the right and z up, in metres and newtons.
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "../device_guard.hpp"
#include "chaincell_client.h"
#include "dhdc.h"

constexpr double MAX_FORCE_N = 2.0;
constexpr std::uint64_t WAIT_NS = 700'000;

static volatile std::sig_atomic_t is_asked = 0;

static void ask(int) { is_asked = 1; }

// The loop; gives the reason where it had to end.
static const char *drive(chaincell_client client, const double (&origin_m)[3], DeviceGuard &guard)
{
    chaincell_tool_pose pose{{0, 0, 0}, {0, 0, 0, 1}, 0, 0};
    chaincell_client_answer answer{};
    auto period = std::chrono::steady_clock::now();
    while (!guard.is_off()) {
        period = std::max(period + std::chrono::milliseconds(1), std::chrono::steady_clock::now());
        std::this_thread::sleep_until(period);
        if (is_asked != 0 || dhdGetButton(0) > 0) {
            guard.stop();
        }
        // The pose: on a doubt the tool lets go where it was last.
        double device_m[3] = {};
        const bool is_read = dhdGetPosition(&device_m[0], &device_m[1], &device_m[2]) >= DHD_NO_ERROR;
        if (guard.position(is_read, device_m)) {
            for (int axis = 0; axis < 3; ++axis) {
                pose.position_m[axis] = static_cast<float>(origin_m[axis] + device_m[axis]);
            }
        }
        pose.engaged = guard.engaged();
        const chaincell_client_code code = chaincell_client_step(client, &pose, 1, WAIT_NS, &answer);
        guard.answer(code, answer);
        // The force: of tool 0.
        const float *felt_n = answer.tools[0].force_n;
        double shown_n[3];
        guard.force({felt_n[0], felt_n[1], felt_n[2]}, shown_n);
        if (dhdSetForceAndTorqueAndGripperForce(shown_n[0], shown_n[1], shown_n[2], 0, 0, 0, 0) < DHD_NO_ERROR) {
            return dhdErrorGetLastStr();
        }
        if (code < 0 && code != CHAINCELL_CLIENT_CODE_POSE) {
            guard.stop();
        }
    }
    return nullptr;
}

int main(int count, char **words)
{
    double origin_m[3] = {};
    if (count != 2 && count != 5) {
        return std::fprintf(stderr, "force_dimension SCENE [X Y Z]\n"), 2;
    }
    for (int axis = 0; count == 5 && axis < 3; ++axis) {
        origin_m[axis] = std::atof(words[2 + axis]);
    }
    std::signal(SIGINT, ask);
    std::signal(SIGTERM, ask);
    chaincell_client client;
    const chaincell_client_code code = chaincell_client_open(CHAINCELL_CLIENT_VERSION, words[1], nullptr, &client);
    if (code < 0) {
        return std::fprintf(stderr, "%s\n", chaincell_client_error_text(code)), 1;
    }
    if (dhdOpen() < 0) {
        return std::fprintf(stderr, "no device (%s): is it plugged in, and may you open it?\n", dhdErrorGetLastStr()), 1;
    }
    std::printf("device %s\n", dhdGetSystemName());
    dhdEnableForce(DHD_ON);
    DeviceGuard guard(MAX_FORCE_N);
    const char *why = drive(client, origin_m, guard);
    // However it ended: the last force is 0.
    dhdSetForceAndTorqueAndGripperForce(0, 0, 0, 0, 0, 0, 0);
    dhdEnableForce(DHD_OFF);
    dhdClose();
    std::printf("largest force %.6f N, %d doubts\n", guard.largest_n, guard.doubts);
    if (why != nullptr) {
        std::fprintf(stderr, "the device takes no force: %s\n", why);
    }
    return chaincell_client_close(client) < 0 || why != nullptr;
}
