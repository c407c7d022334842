/*
 * Presses the surface of a body with two tools, with friction, and takes hold of it. Prints what each
 * tool feels, and the contacts one by one.
 *
 *   chaincell bake box:6x6x4x0.01 --young-pa 5000 --poisson 0.4 --coarse 2.5 \
 *       --contact-surface yes -o touch6.chaincell
 *   cargo build --release -p chaincell-ffi
 *   cc -std=c99 -Ikernel/ffi/include kernel/ffi/examples/grasp.c \
 *       target/release/libchaincell_ffi.a -lpthread -ldl -lm -o grasp
 *   ./grasp touch6.chaincell 0.03
 *
 * The number is the height of the body's top [m]. A ball and a jaw of two capsules go 5 mm down into
 * it in 100 ticks, 2 mm each towards the other in 80, and the jaw grips; it pulls 6 mm up in 60, and lets
 * go within 20 ticks.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "chaincell.h"

enum { BALL, JAW, TOOLS };
enum { DOWN = 100, TOGETHER = 180, PULLED = 240, TICKS = 270, PRINT_EVERY = 60, CONTACTS_MAX = 64 };

static const float FRICTION = 0.3f, APART_M = 0.012f;

/* Says what was refused; nothing where all is well. */
static int refused(const char *what, chaincell_code code)
{
    if (code == CHAINCELL_CODE_OK) {
        return 0;
    }
    fprintf(stderr, "grasp: %s: %s (%d)\n", what, chaincell_code_text(code), (int)code);
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

/* A ball, and a jaw of two capsules side by side. */
static chaincell_code choose(chaincell_tissue *tissue)
{
    static const chaincell_tool_part parts[3] = {
        {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 0.0f}, 0.005f},
        {{0.0f, -0.004f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 0.004f}, 0.005f},
        {{0.0f, 0.004f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, {0.0f, 0.0f, 0.004f}, 0.005f}};
    static const uint32_t counts[TOOLS] = {1, 2};

    return chaincell_choose_tools(tissue, parts, counts, TOOLS, FRICTION, NULL);
}

/* How far a movement from one tick to another has come, 0 to 1. */
static float share(int tick, int from, int to)
{
    if (tick < from) {
        return 0.0f;
    }
    return tick < to ? (float)(tick - from) / (float)(to - from) : 1.0f;
}

/* Where the tools are in a tick. */
static void place(int tick, float top_m, chaincell_tool_pose poses[TOOLS])
{
    static const float reach_m[TOOLS] = {0.005f, 0.009f};
    const float down_m = 0.005f * share(tick, 0, DOWN);
    const float aside_m = APART_M - 0.002f * share(tick, DOWN, TOGETHER);
    int tool;

    for (tool = 0; tool < TOOLS; tool++) {
        chaincell_tool_pose *pose = &poses[tool];

        pose->position_m[0] = tool == BALL ? -aside_m : aside_m;
        pose->position_m[1] = 0.001f;
        pose->position_m[2] = top_m + reach_m[tool] - down_m;
        pose->orientation[3] = 1.0f;
        pose->orientation[0] = pose->orientation[1] = pose->orientation[2] = 0.0f;
        pose->engaged = 1;
        pose->opening_turns_q16 = 0;
    }
    poses[JAW].position_m[2] += 0.006f * share(tick, TOGETHER, PULLED);
}

/* What each tool feels, and its contacts. */
static int print(chaincell_tissue *tissue, const chaincell_output outputs[TOOLS], int tick)
{
    chaincell_contact contacts[CONTACTS_MAX];
    size_t count, held, at;
    uint32_t tool;

    for (tool = 0; tool < TOOLS; tool++) {
        const chaincell_tool_output felt = outputs[tool].tool;

        if (refused("gripped", chaincell_gripped(tissue, tool, &held))) {
            return 1;
        }
        printf("tick %3d: tool %" PRIu32 ": force %.4e %.4e %.4e N, torque %.4e %.4e %.4e N m, "
               "%" PRIu32 " contacts, %lu samples gripped\n",
               tick, tool, (double)felt.force_n[0], (double)felt.force_n[1],
               (double)felt.force_n[2], (double)felt.torque_n_m[0], (double)felt.torque_n_m[1],
               (double)felt.torque_n_m[2], felt.contacts, (unsigned long)held);
    }
    if (refused("contacts", chaincell_contact_forces(tissue, contacts, CONTACTS_MAX, &count))) {
        return 1;
    }
    if (count > CONTACTS_MAX) {
        printf("  the first %d of %lu contacts\n", CONTACTS_MAX, (unsigned long)count);
        count = CONTACTS_MAX;
    }
    for (at = 0; at < count; at++) {
        const chaincell_contact *of = &contacts[at];

        printf("  triangle %3" PRIu32 ", tool %" PRIu32 ", part %" PRIu32
               ": normal %.3e %.3e %.3e N, across %.3e %.3e %.3e N, on %.2e m2\n",
               of->triangle, of->tool, of->part, (double)of->normal_n[0], (double)of->normal_n[1],
               (double)of->normal_n[2], (double)of->tangential_n[0], (double)of->tangential_n[1],
               (double)of->tangential_n[2], (double)of->area_m2);
    }
    return 0;
}

/* Press, grasp, pull, let go. */
static int grasp(chaincell_tissue *tissue, float top_m)
{
    chaincell_tool_pose poses[TOOLS];
    chaincell_output outputs[TOOLS];
    double work_j = 0.0;
    uint64_t hash;
    int tick;

    if (refused("tools", choose(tissue))) {
        return EXIT_FAILURE;
    }
    for (tick = 0; tick < TICKS; tick++) {
        if (tick == TOGETHER && refused("grip", chaincell_grip(tissue, JAW, NULL))) {
            return EXIT_FAILURE;
        }
        if (tick == PULLED && refused("let go", chaincell_let_go(tissue, JAW, 20))) {
            return EXIT_FAILURE;
        }
        place(tick, top_m, poses);
        if (refused("tick", chaincell_tick(tissue, poses, TOOLS, NULL, outputs))) {
            return EXIT_FAILURE;
        }
        work_j += (double)outputs[BALL].work_j + (double)outputs[JAW].work_j;
        if (tick % PRINT_EVERY == PRINT_EVERY - 1 && print(tissue, outputs, tick)) {
            return EXIT_FAILURE;
        }
    }
    if (refused("hash", chaincell_state_hash(tissue, &hash))) {
        return EXIT_FAILURE;
    }
    printf("work %.4e J\nstate hash %016" PRIx64 "\n", work_j, hash);
    return EXIT_SUCCESS;
}

/* Puts a body into storage of its own, with room for the tools. */
static int run(const chaincell_model *model, float top_m)
{
    static const chaincell_room room = {.tools = TOOLS, .triangles = 256, .samples = 512};
    chaincell_settings settings;
    chaincell_tissue *tissue;
    void *whole = NULL, *storage;
    size_t bytes, align;
    int status = EXIT_FAILURE;

    if (refused("settings",
                chaincell_settings_default(model, CHAINCELL_SCHEME_PREDICT, &settings)) ||
        refused("size", chaincell_model_size(model, CHAINCELL_SCHEME_PREDICT, &room, &bytes,
                                             &align))) {
        return EXIT_FAILURE;
    }
    storage = aligned(bytes, align, &whole);
    if (storage == NULL) {
        fprintf(stderr, "grasp: no memory for %lu bytes\n", (unsigned long)bytes);
    } else if (!refused("tissue", chaincell_tissue_init(storage, bytes, model,
                                                        CHAINCELL_SCHEME_PREDICT, &room, &settings,
                                                        &tissue, NULL))) {
        printf("%lu bytes\n", (unsigned long)bytes);
        status = grasp(tissue, top_m);
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
        fprintf(stderr, "usage: grasp MODEL.chaincell HEIGHT_OF_THE_TOP_IN_METRES\n");
        return EXIT_FAILURE;
    }
    if (chaincell_version() != CHAINCELL_VERSION) {
        fprintf(stderr, "grasp: header and library are of different versions\n");
        return EXIT_FAILURE;
    }
    image = read_image(argv[1], &bytes, &whole);
    if (image == NULL) {
        fprintf(stderr, "grasp: cannot read %s\n", argv[1]);
    } else if (!refused(argv[1], chaincell_model_init(&model, image, bytes, NULL))) {
        status = run(&model, top_m);
    }
    free(whole);
    return status;
}
