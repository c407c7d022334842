/* Prints what the header's macros say of the sizes: scheme, bound, cells, contacts, coarse functions. With
 * any argument those of three bodies of nodal shapes in place of these. */
#include <stdio.h>

#include "chaincell.h"

/* The macros stand where only a constant may stand. */
CHAINCELL_ALIGNED static unsigned char storage[CHAINCELL_TISSUE_BYTES(512, 4, 48)];
CHAINCELL_SHAPE_ALIGNED static unsigned char shapes[CHAINCELL_SHAPE_BYTES(8, 4, 48)];
CHAINCELL_SHAPE_ALIGNED static unsigned char
    tools[CHAINCELL_SHAPE_BYTES(8, 0, 0) + CHAINCELL_TOUCH_BYTES(8, 1, 64, 32)];

static const uint32_t counts[][3] = {{1, 0, 0},      {1, 1, 1},        {512, 4, 48},
                                     {1000, 7, 0},   {5773, 64, 367},  {5773, 65, 369},
                                     {65535, 0, 0},  {65535, 9, 1024}, {65535, 65535, 0},
                                     {300, 300, 100}};

static void line(int scheme, size_t bound, const uint32_t of[3])
{
    printf("%d %lu %lu %lu %lu\n", scheme, (unsigned long)bound, (unsigned long)of[0],
           (unsigned long)of[1], (unsigned long)of[2]);
}

int main(int argc, char **argv)
{
    size_t at;

    (void)argv;
    if (!CHAINCELL_IS_ALIGNED(storage) || CHAINCELL_IS_ALIGNED(storage + 8) ||
        (uintptr_t)shapes % CHAINCELL_SHAPE_ALIGN != 0 ||
        (uintptr_t)tools % CHAINCELL_SHAPE_ALIGN != 0) {
        return 1;
    }
    if (sizeof shapes - CHAINCELL_TISSUE_BYTES(8, 4, 0) <
        8 * (size_t)CHAINCELL_CELL_BYTES_SHAPE) {
        return 2;
    }
    if (argc > 1) {
        printf("%lu\n%lu\n%lu\n", (unsigned long)CHAINCELL_SHAPE_BYTES(144, 2, 18),
               (unsigned long)(CHAINCELL_SHAPE_BYTES_OF(CHAINCELL_CELL_BYTES_PREDICT, 144, 0, 18) +
                               CHAINCELL_TOUCH_BYTES(144, 2, 256, 512)),
               (unsigned long)(CHAINCELL_SHAPE_BYTES(130, 0, 8) +
                               CHAINCELL_TOUCH_BYTES(130, 1, 64, 0) +
                               CHAINCELL_CUT_BYTES(14878, 1)));
        return 0;
    }
    for (at = 0; at < sizeof counts / sizeof counts[0]; at++) {
        const uint32_t *of = counts[at];

        line(CHAINCELL_SCHEME_TRACK, CHAINCELL_TISSUE_BYTES(of[0], of[1], of[2]), of);
        line(CHAINCELL_SCHEME_PREDICT,
             CHAINCELL_TISSUE_BYTES_OF(CHAINCELL_CELL_BYTES_PREDICT, of[0], of[1], of[2]), of);
        line(CHAINCELL_SCHEME_EULER,
             CHAINCELL_TISSUE_BYTES_OF(CHAINCELL_CELL_BYTES_EULER, of[0], of[1], 0), of);
        line(CHAINCELL_SCHEME_RKL2,
             CHAINCELL_TISSUE_BYTES_OF(CHAINCELL_CELL_BYTES_RKL2, of[0], of[1], 0), of);
    }
    return 0;
}
