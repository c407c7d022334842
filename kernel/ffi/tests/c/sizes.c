/* Prints what the header's macros say of the sizes, and what the library says, side by side. */
#include <stdio.h>

#include "chaincell.h"

/* The macros stand where only a constant may stand. */
CHAINCELL_ALIGNED static unsigned char storage[CHAINCELL_TISSUE_BYTES(512, 4, 48)];
CHAINCELL_SHAPE_ALIGNED static unsigned char shapes[CHAINCELL_SHAPE_BYTES(8, 4, 48)];
CHAINCELL_SHAPE_ALIGNED static unsigned char
    tools[CHAINCELL_SHAPE_BYTES(8, 0, 0) + CHAINCELL_TOUCH_BYTES(8, 1, 64, 32)];

static void line(int32_t scheme, size_t bound, uint32_t cells, uint32_t contacts, uint32_t coarse_functions)
{
    printf("%d %lu %lu\n", (int)scheme, (unsigned long)bound,
           (unsigned long)chaincell_tissue_size(scheme, cells, contacts, coarse_functions));
}

int main(void)
{
    static const uint32_t counts[][3] = {{1, 0, 0},      {1, 1, 1},        {512, 4, 48},
                                         {1000, 7, 0},   {5773, 64, 367},  {5773, 65, 369},
                                         {65535, 0, 0},  {65535, 9, 1024}, {65535, 65535, 0},
                                         {300, 300, 100}};
    size_t at;

    if (!CHAINCELL_IS_ALIGNED(storage) || CHAINCELL_IS_ALIGNED(storage + 8)) {
        return 1;
    }
    if ((uintptr_t)shapes % CHAINCELL_SHAPE_ALIGN != 0 ||
        sizeof shapes - CHAINCELL_TISSUE_BYTES(8, 4, 0) <
            8 * (size_t)CHAINCELL_CELL_BYTES_SHAPE) {
        return 4;
    }
    if ((uintptr_t)tools % CHAINCELL_SHAPE_ALIGN != 0) {
        return 5;
    }
    if (CHAINCELL_ALIGN != chaincell_tissue_align() || CHAINCELL_VERSION != chaincell_version()) {
        return 2;
    }
    if (sizeof storage < chaincell_tissue_size(CHAINCELL_SCHEME_TRACK, 512, 4, 48)) {
        return 3;
    }
    for (at = 0; at < sizeof counts / sizeof counts[0]; at++) {
        const uint32_t cells = counts[at][0], contacts = counts[at][1], coarse_functions = counts[at][2];

        line(CHAINCELL_SCHEME_TRACK, CHAINCELL_TISSUE_BYTES(cells, contacts, coarse_functions), cells, contacts,
             coarse_functions);
        line(CHAINCELL_SCHEME_PREDICT,
             CHAINCELL_TISSUE_BYTES_OF(CHAINCELL_CELL_BYTES_PREDICT, cells, contacts, coarse_functions), cells,
             contacts, coarse_functions);
        line(CHAINCELL_SCHEME_EULER,
             CHAINCELL_TISSUE_BYTES_OF(CHAINCELL_CELL_BYTES_EULER, cells, contacts, 0), cells,
             contacts, coarse_functions);
        line(CHAINCELL_SCHEME_RKL2,
             CHAINCELL_TISSUE_BYTES_OF(CHAINCELL_CELL_BYTES_RKL2, cells, contacts, 0), cells,
             contacts, coarse_functions);
    }
    printf("%lu\n", (unsigned long)CHAINCELL_SHAPE_BYTES(144, 2, 18));
    printf("%lu\n", (unsigned long)(CHAINCELL_SHAPE_BYTES_OF(CHAINCELL_CELL_BYTES_PREDICT, 144, 0, 18) +
                                    CHAINCELL_TOUCH_BYTES(144, 2, 256, 512)));
    return 0;
}
