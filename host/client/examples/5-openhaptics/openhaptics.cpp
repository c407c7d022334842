// Example 5: a device of OpenHaptics (Touch, Touch X) on a served tissue, by its HD interface.
//
// `chaincell serve liver.chaincell --tool sphere:0.012 --device touch --scene left` runs meanwhile; then
// `./openhaptics left [X Y Z]`, the position of the device's zero in the scene [m]. The device's button or Ctrl-C ends
// it. Its axes are x to the right, y up and z to the user, in millimetres and newtons: the scene's are x, -z and y.
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include <HD/hd.h>

#include "../device_guard.hpp"
#include "chaincell_client.h"

constexpr double MAX_FORCE_N = 2.0;

static volatile std::sig_atomic_t is_asked = 0;

static void ask(int) { is_asked = 1; }

// What the servo thread has.
struct Loop {
    HHD device;
    chaincell_client client;
    double origin_m[3];
    DeviceGuard guard{MAX_FORCE_N};
    chaincell_tool_pose pose{{0, 0, 0}, {0, 0, 0, 1}, 0, 0};
    std::atomic<bool> has_ended{false};
};

// A period of the servo thread: the newest answer in, a pose out, and no waiting.
static HDCallbackCode HDCALLBACK period(void *data)
{
    Loop &loop = *static_cast<Loop *>(data);
    hdBeginFrame(loop.device);
    HDdouble device_mm[3] = {};
    HDint buttons = 0;
    hdGetDoublev(HD_CURRENT_POSITION, device_mm);
    hdGetIntegerv(HD_CURRENT_BUTTONS, &buttons);
    // An error of the end of the last frame, too.
    const bool is_read = hdGetError().errorCode == HD_SUCCESS;
    if (is_asked != 0 || (is_read && (buttons & HD_DEVICE_BUTTON_1) != 0)) {
        loop.guard.stop();
    }
    // The answer to the pose before.
    chaincell_client_answer answer{};
    chaincell_client_code code = chaincell_client_try_receive(loop.client, &answer);
    loop.guard.answer(code, answer);
    // The pose: on a doubt the tool lets go where it was last.
    const double scene_m[3] = {1e-3 * device_mm[0], -1e-3 * device_mm[2], 1e-3 * device_mm[1]};
    if (loop.guard.position(is_read, scene_m)) {
        for (int axis = 0; axis < 3; ++axis) {
            loop.pose.position_m[axis] = static_cast<float>(loop.origin_m[axis] + scene_m[axis]);
        }
    }
    loop.pose.engaged = loop.guard.engaged();
    code = chaincell_client_send(loop.client, &loop.pose, 1, nullptr);
    if (code < 0 && code != CHAINCELL_CLIENT_CODE_POSE) {
        loop.guard.stop();
    }
    // The force of tool 0, back on the device's axes; the last one is 0.
    const float *felt_n = answer.tools[0].force_n;
    double shown_n[3];
    loop.guard.force({felt_n[0], felt_n[2], -felt_n[1]}, shown_n);
    hdSetDoublev(HD_CURRENT_FORCE, shown_n);
    hdEndFrame(loop.device);
    loop.has_ended = loop.guard.is_off();
    return loop.has_ended ? HD_CALLBACK_DONE : HD_CALLBACK_CONTINUE;
}

int main(int count, char **words)
{
    if (count != 2 && count != 5) {
        return std::fprintf(stderr, "openhaptics SCENE [X Y Z]\n"), 2;
    }
    Loop loop{};
    for (int axis = 0; count == 5 && axis < 3; ++axis) {
        loop.origin_m[axis] = std::atof(words[2 + axis]);
    }
    std::signal(SIGINT, ask);
    std::signal(SIGTERM, ask);
    const chaincell_client_code code = chaincell_client_open(CHAINCELL_CLIENT_VERSION, words[1], nullptr, &loop.client);
    if (code < 0) {
        return std::fprintf(stderr, "%s\n", chaincell_client_error_text(code)), 1;
    }
    loop.device = hdInitDevice(HD_DEFAULT_DEVICE);
    if (hdGetError().errorCode != HD_SUCCESS) {
        return std::fprintf(stderr, "no device: is it plugged in, and set up with the driver's tool?\n"), 1;
    }
    hdEnable(HD_FORCE_OUTPUT);
    const HDSchedulerHandle handle = hdScheduleAsynchronous(period, &loop, HD_MAX_SCHEDULER_PRIORITY);
    hdStartScheduler();
    while (!loop.has_ended) {
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    hdStopScheduler();
    hdUnschedule(handle);
    hdDisable(HD_FORCE_OUTPUT);
    hdDisableDevice(loop.device);
    std::printf("largest force %.6f N, %d doubts\n", loop.guard.largest_n, loop.guard.doubts);
    return chaincell_client_close(loop.client) < 0;
}
