// A device that is none, for the stubs of both interfaces: it moves along a press, and judges the forces that it gets.
#ifndef CHAINCELL_STUB_PRESS_HPP
#define CHAINCELL_STUB_PRESS_HPP

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace stub {

constexpr int PERIODS = 900; // then its button is pressed
constexpr int FAULT = 750;   // first period of STUB_FAULT: nan, jump or error; the device is down
constexpr int FAULT_PERIODS = 5;
constexpr int OFF_PERIODS = 20; // after these the force is off
constexpr double LIMIT_N = 2.0;
constexpr double JUMP_N = 0.15;

inline int reads = 0, forces = 0;
inline double last_n = 0.0, largest_n = 0.0;

// The fault that is asked for, or "none".
inline const char *fault()
{
    const char *asked = std::getenv("STUB_FAULT");
    return asked == nullptr ? "none" : asked;
}

inline bool has_fault(const char *name)
{
    return std::strcmp(fault(), name) == 0 && reads >= FAULT && reads < FAULT + FAULT_PERIODS;
}

// Height of the device in this period, 12 mm down and up again every half second [m].
inline double height_m()
{
    ++reads;
    if (has_fault("nan")) {
        return std::nan("");
    }
    return 0.006 * (std::cos(reads * 3.14159265358979 / 250.0) - 1.0) + (has_fault("jump") ? 0.05 : 0.0);
}

[[noreturn]] inline void fail(const char *what)
{
    std::fprintf(stderr, "stub: %s in period %d\n", what, reads);
    std::_Exit(3);
}

inline void take(const double x, const double y, const double z)
{
    const double size_n = std::sqrt(x * x + y * y + z * z);
    ++forces;
    if (!(size_n <= LIMIT_N)) {
        fail("a force above the limit");
    }
    if (std::abs(size_n - last_n) > JUMP_N) {
        fail("a jump of the force");
    }
    if (std::strcmp(fault(), "none") != 0 && reads >= FAULT + OFF_PERIODS && reads < FAULT + 100 && size_n != 0.0) {
        fail("a force after a fault");
    }
    last_n = size_n;
    largest_n = size_n > largest_n ? size_n : largest_n;
}

inline void close()
{
    if (last_n != 0.0) {
        fail("the last force is not 0");
    }
    std::printf("stub: %d forces, largest %.6f N, the last one 0\n", forces, largest_n);
}

} // namespace stub

#endif
