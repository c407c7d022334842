// Declarations of our own for the few functions of the HD interface that example 5 uses, where OpenHaptics is not: a
// device that moves along a press, in a servo thread.
#ifndef CHAINCELL_STUB_HD_H
#define CHAINCELL_STUB_HD_H

#include <chrono>
#include <thread>

#include "../press.hpp"

using HHD = unsigned;
using HDdouble = double;
using HDint = int;
using HDenum = unsigned;
using HDCallbackCode = unsigned;
using HDSchedulerHandle = unsigned long;
struct HDErrorInfo {
    unsigned errorCode;
};

#define HDCALLBACK
#define HD_DEFAULT_DEVICE nullptr
#define HD_SUCCESS 0u
#define HD_CALLBACK_DONE 0u
#define HD_CALLBACK_CONTINUE 1u
#define HD_MAX_SCHEDULER_PRIORITY 1
#define HD_DEVICE_BUTTON_1 1
enum : HDenum { HD_CURRENT_POSITION, HD_CURRENT_BUTTONS, HD_CURRENT_FORCE, HD_FORCE_OUTPUT };

namespace stub {
inline HDCallbackCode (*callback)(void *) = nullptr;
inline void *data = nullptr;
inline std::thread servo;
} // namespace stub

inline HHD hdInitDevice(const char *) { return 1; }
inline void hdDisableDevice(HHD) { stub::close(); }
inline void hdEnable(HDenum) {}
inline void hdDisable(HDenum) {}
inline void hdBeginFrame(HHD) {}
inline void hdEndFrame(HHD) {}
inline HDErrorInfo hdGetError() { return {stub::has_fault("error") ? 1u : 0u}; }

inline void hdGetDoublev(HDenum, HDdouble *position_mm)
{
    position_mm[0] = position_mm[2] = 0.0;
    position_mm[1] = 1e3 * stub::height_m();
}

inline void hdGetIntegerv(HDenum, HDint *buttons) { *buttons = stub::reads >= stub::PERIODS; }
inline void hdSetDoublev(HDenum, const HDdouble *force_n) { stub::take(force_n[0], force_n[1], force_n[2]); }

inline HDSchedulerHandle hdScheduleAsynchronous(HDCallbackCode (*callback)(void *), void *data, unsigned short)
{
    stub::callback = callback;
    stub::data = data;
    return 1;
}

inline void hdStartScheduler()
{
    stub::servo = std::thread([] {
        auto period = std::chrono::steady_clock::now();
        while (stub::callback(stub::data) == HD_CALLBACK_CONTINUE) {
            period = std::max(period + std::chrono::milliseconds(1), std::chrono::steady_clock::now());
            std::this_thread::sleep_until(period);
        }
    });
}

inline void hdStopScheduler() { stub::servo.join(); }
inline void hdUnschedule(HDSchedulerHandle) {}

#endif
