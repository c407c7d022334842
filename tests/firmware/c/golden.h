/* A golden scene in C. */
#ifndef GOLDEN_H
#define GOLDEN_H

#include "chaincell.h"

/* The sample of a tick, for presses of a depth. */
chaincell_tool_pose golden_pose(float reach_m, uint32_t tick);

/* The digest (0 at first) with one more tick's answer. */
uint64_t golden_absorb(uint64_t digest, uint64_t state_hash, const chaincell_output *output);

#endif
