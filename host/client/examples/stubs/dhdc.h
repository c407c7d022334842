// Declarations of our own for the few functions of the DHD interface that example 4 uses, where the SDK is not: a device
// that moves along a press.
#ifndef CHAINCELL_STUB_DHDC_H
#define CHAINCELL_STUB_DHDC_H

#include "press.hpp"

#define DHD_NO_ERROR 0
#define DHD_ON 1
#define DHD_OFF 0

inline int dhdOpen() { return 0; }
inline int dhdClose() { return stub::close(), 0; }
inline const char *dhdGetSystemName() { return "stub"; }
inline const char *dhdErrorGetLastStr() { return "stub"; }
inline int dhdEnableForce(unsigned char) { return 0; }
inline int dhdGetButton(int) { return stub::reads >= stub::PERIODS; }

inline int dhdGetPosition(double *x, double *y, double *z)
{
    *x = *y = 0.0;
    *z = stub::height_m();
    return stub::has_fault("error") ? -1 : 0;
}

inline int dhdSetForceAndTorqueAndGripperForce(double x, double y, double z, double, double, double, double)
{
    return stub::take(x, y, z), 0;
}

#endif
