/*
 * Cuts a body with a blade. Prints what the blade feels, and the state of the cuts.
 *
 *   chaincell bake box:5x5x4x0.01 --young-pa 5000 --poisson 0.4 --coarse 2.5 \
 *       --contact-surface yes --cuttable --cut-spare 0.3 --toughness-j-per-m2 10 \
 *       -o blade5.chaincell
 *   cargo build --release -p chaincell-ffi --features cut
 *   cc -std=c99 -Ikernel/ffi/include kernel/ffi/examples/cut.c \
 *       target/release/libchaincell_ffi.a -lpthread -ldl -lm -o cut
 *   ./cut blade5.chaincell 0.03
 *
 * The number is the height of the body's top [m]. An edge of 32 mm goes down from 0.5 mm above it by
 * 0.1 mm a tick; after 200 ticks it stays, and a face of the first tetrahedron is opened without it.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "chaincell.h"

enum { DOWN = 200, TICKS = 240, PRINT_EVERY = 40 };

/* Says what was refused; nothing where all is well. */
static int refused(const char *what, chaincell_code code)
{
    if (code == CHAINCELL_CODE_OK) {
        return 0;
    }
    fprintf(stderr, "cut: %s: %s (%d)\n", what, chaincell_code_text(code), (int)code);
    return 1;
}

/* Memory at a multiple of `align` bytes; `whole` is what to free. */
static void *aligned(size_t bytes, size_t align, void **whole)
{
    *whole = malloc(bytes + align - 1);
    if (*whole == NULL) {
        return NULL;
    }
    return (void *)(((uintptr_t)*whole + align - 1) / align * align);
}

/* Reads a file to where an image may start; null where that fails. */
static void *read_image(const char *path, size_t *bytes, void **whole)
{
    FILE *file = fopen(path, "rb");
    long length = -1;
    void *image = NULL;

    if (file == NULL) {
        return NULL;
    }
    if (fseek(file, 0, SEEK_END) == 0) {
        length = ftell(file);
    }
    if (length > 0 && fseek(file, 0, SEEK_SET) == 0) {
        *bytes = (size_t)length;
        image = aligned(*bytes, CHAINCELL_ALIGN, whole);
        if (image != NULL && fread(image, 1, *bytes, file) != *bytes) {
            image = NULL;
        }
    }
    fclose(file);
    return image;
}

/* The edge of a blade along x, which cuts towards -z. */
static chaincell_code choose(chaincell_tissue *tissue)
{
    static const chaincell_tool_part edge = {
        {0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, {0.016f, 0.0f, 0.0f}, 0.0f};
    static const uint32_t count = 1;

    return chaincell_choose_tools(tissue, &edge, &count, 1, 0.0f, NULL);
}

/* Where the blade is in a tick. */
static void place(int tick, float top_m, chaincell_tool_pose *pose)
{
    static const chaincell_tool_pose still = {{0.001f, -0.001f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, 1, 0};

    *pose = still;
    pose->position_m[2] = top_m + 0.0005f - 0.0001f * (float)(tick < DOWN ? tick : DOWN);
}

/* What the blade feels, and the cuts. */
static int print(chaincell_tissue *tissue, const chaincell_output *output, int tick)
{
    chaincell_cuts cuts;

    if (refused("cuts", chaincell_cut(tissue, NULL, 0, &cuts, NULL))) {
        return 1;
    }
    printf("tick %3d: force %.4e %.4e %.4e N, area %.3e m2, work %.3e J: %" PRIu32
           " faces open, %" PRIu32 " copies, %" PRIu32 " refused\n",
           tick, (double)output->tool.force_n[0], (double)output->tool.force_n[1],
           (double)output->tool.force_n[2], (double)cuts.area_m2, (double)cuts.work_j,
           cuts.opened_faces, cuts.copies, cuts.refused);
    return 0;
}

/* The blade goes down, then a face is opened. */
static int cut(chaincell_tissue *tissue, float top_m)
{
    static const chaincell_face face = {0, 0};
    chaincell_tool_pose pose;
    chaincell_output output;
    uint64_t hash;
    int tick;

    if (refused("blade", choose(tissue))) {
        return EXIT_FAILURE;
    }
    for (tick = 0; tick < TICKS; tick++) {
        if (tick == DOWN && refused("face", chaincell_cut(tissue, &face, 1, NULL, NULL))) {
            return EXIT_FAILURE;
        }
        place(tick, top_m, &pose);
        if (refused("tick", chaincell_tick(tissue, &pose, 1, NULL, &output))) {
            return EXIT_FAILURE;
        }
        if (tick % PRINT_EVERY == PRINT_EVERY - 1 && print(tissue, &output, tick)) {
            return EXIT_FAILURE;
        }
    }
    if (refused("hash", chaincell_state_hash(tissue, &hash))) {
        return EXIT_FAILURE;
    }
    printf("state hash %016" PRIx64 "\n", hash);
    return EXIT_SUCCESS;
}

/* Puts a body into storage of its own, with memory for cuts. */
static int run(const chaincell_model *model, float top_m)
{
    static const chaincell_room room = {.tools = 1, .triangles = 64, .cuts = 1};
    chaincell_settings settings;
    chaincell_tissue *tissue;
    void *whole = NULL, *storage;
    size_t bytes, align;
    int status = EXIT_FAILURE;

    if (refused("settings",
                chaincell_settings_default(model, CHAINCELL_SCHEME_TRACK, &settings)) ||
        refused("size",
                chaincell_model_size(model, CHAINCELL_SCHEME_TRACK, &room, &bytes, &align))) {
        return EXIT_FAILURE;
    }
    storage = aligned(bytes, align, &whole);
    if (storage == NULL) {
        fprintf(stderr, "cut: no memory for %lu bytes\n", (unsigned long)bytes);
    } else if (!refused("tissue", chaincell_tissue_init(storage, bytes, model,
                                                        CHAINCELL_SCHEME_TRACK, &room, &settings,
                                                        &tissue, NULL))) {
        printf("%lu bytes\n", (unsigned long)bytes);
        status = cut(tissue, top_m);
    }
    free(whole);
    return status;
}

int main(int argc, char **argv)
{
    static chaincell_model model;
    void *whole = NULL, *image;
    size_t bytes = 0;
    char *end = NULL;
    int status = EXIT_FAILURE;
    const float top_m = argc == 3 ? (float)strtod(argv[2], &end) : 0.0f;

    if (argc != 3 || end == argv[2] || *end != '\0' || !isfinite(top_m)) {
        fprintf(stderr, "usage: cut MODEL.chaincell HEIGHT_OF_THE_TOP_IN_METRES\n");
        return EXIT_FAILURE;
    }
    if (chaincell_version() != CHAINCELL_VERSION) {
        fprintf(stderr, "cut: header and library are of different versions\n");
        return EXIT_FAILURE;
    }
    image = read_image(argv[1], &bytes, &whole);
    if (image == NULL) {
        fprintf(stderr, "cut: cannot read %s\n", argv[1]);
    } else if (!refused(argv[1], chaincell_model_init(&model, image, bytes, NULL))) {
        status = run(&model, top_m);
    }
    free(whole);
    return status;
}
