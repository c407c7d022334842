// The header alone, as C++.
#include "chaincell.h"

CHAINCELL_ALIGNED static unsigned char storage[CHAINCELL_TISSUE_BYTES(8, 1, 0)];

static_assert(sizeof(chaincell_output) == 60, "an output is fifteen words");
static_assert(sizeof(chaincell_tool_part) == 44, "a part is eleven words");
static_assert(sizeof(chaincell_tool_pose) == 32, "a pose is eight words");
static_assert(sizeof(chaincell_tool_output) == 32, "what a tool feels is eight words");
static_assert(sizeof(chaincell_contact) == 60, "a contact is fifteen words");
static_assert(sizeof(chaincell_room) == 24, "room is six words");
static_assert(sizeof(chaincell_code) == 4, "codes are 32 bits wide");

extern "C" bool usable()
{
    return CHAINCELL_IS_ALIGNED(storage) && chaincell_version() == CHAINCELL_VERSION;
}
