/*
 * Presses a body through the C interface and prints what it feels.
 *
 *   cargo build --release -p chaincell-ffi
 *   cc -std=c99 -Ikernel/ffi/include kernel/ffi/examples/press.c \
 *       target/release/libchaincell_ffi.a -lpthread -ldl -lm -o press
 *   ./press liver.chaincell 17 23
 *
 * The tool takes hold of the nodes (input ids), goes 20 mm down in 200 ticks, and lets go for 50.
 */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "chaincell.h"

enum { PRESS_TICKS = 200, TICKS = 250, PRINT_EVERY = 25, CONTACTS_MAX = 64 };

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

/* Says what was refused; nothing where all is well. */
static int refused(const char *what, chaincell_code code, const chaincell_detail *detail)
{
    if (code == CHAINCELL_CODE_OK) {
        return 0;
    }
    fprintf(stderr, "press: %s: %s (%d; section %" PRIu32 ", position %" PRIu32 ", %lu of %lu)\n",
            what, chaincell_code_text(code), (int)code, detail->section, detail->position,
            (unsigned long)detail->available, (unsigned long)detail->needed);
    return 1;
}

/* 250 ticks and the state hash. */
static int press(chaincell_tissue *tissue)
{
    chaincell_detail none = {0, 0, 0, 0, 0.0f};
    chaincell_tool_pose pose = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, 0, 0};
    chaincell_output output;
    chaincell_code code;
    uint64_t hash;
    uint32_t tick;

    for (tick = 0; tick < TICKS; tick++) {
        pose.position_m[2] = -0.0001f * (float)tick;
        pose.engaged = tick < PRESS_TICKS;
        code = chaincell_tick(tissue, &pose, 1, NULL, &output);
        if (refused("tick", code, &none)) {
            return EXIT_FAILURE;
        }
        if (tick % PRINT_EVERY == PRINT_EVERY - 1) {
            printf("tick %3" PRIu32 ": force %.6e %.6e %.6e N, energy %.6e J, flags %" PRIu32 "\n",
                   tick, (double)output.tool.force_n[0], (double)output.tool.force_n[1],
                   (double)output.tool.force_n[2], (double)output.energy_j, output.tool.flags);
        }
    }
    if (refused("hash", chaincell_state_hash(tissue, &hash), &none)) {
        return EXIT_FAILURE;
    }
    printf("state hash %016" PRIx64 "\n", hash);
    return EXIT_SUCCESS;
}

/* Puts a body into storage of its own, and presses it. */
static int run(const chaincell_model *model, const uint32_t *ids, uint32_t count)
{
    chaincell_room room = {0, 0, 0, 0, 0, 0};
    chaincell_detail detail;
    chaincell_settings settings;
    chaincell_info info;
    chaincell_tissue *tissue;
    chaincell_code code;
    void *whole = NULL, *storage;
    size_t bytes, align;
    int status = EXIT_FAILURE;

    room.contacts = count;
    if (chaincell_model_info(model, &info) != CHAINCELL_CODE_OK ||
        chaincell_settings_default(model, CHAINCELL_SCHEME_TRACK, &settings) != CHAINCELL_CODE_OK ||
        chaincell_model_size(model, CHAINCELL_SCHEME_TRACK, &room, &bytes, &align) !=
            CHAINCELL_CODE_OK) {
        return EXIT_FAILURE;
    }
    storage = aligned(bytes, align, &whole);
    if (storage == NULL) {
        fprintf(stderr, "press: no memory for %" PRIu32 " cells\n", info.cells);
        free(whole);
        return EXIT_FAILURE;
    }
    printf("%" PRIu32 " cells, %" PRIu32 " links, %" PRIu32 " coarse functions: %lu bytes\n", info.cells,
           info.links, info.coarse_functions, (unsigned long)bytes);
    code = chaincell_tissue_init(storage, bytes, model, CHAINCELL_SCHEME_TRACK, &room, &settings,
                                 &tissue, &detail);
    if (!refused("tissue", code, &detail)) {
        code = chaincell_choose_contacts(tissue, ids, count, &detail);
        if (!refused("contacts", code, &detail)) {
            status = press(tissue);
        }
    }
    free(whole);
    return status;
}

int main(int argc, char **argv)
{
    static chaincell_model model;
    uint32_t ids[CONTACTS_MAX], count = 0;
    chaincell_detail detail;
    chaincell_code code;
    void *whole = NULL, *image;
    size_t bytes = 0;
    int status = EXIT_FAILURE, at;

    if (argc < 3 || argc > 2 + CONTACTS_MAX) {
        fprintf(stderr, "usage: press MODEL.chaincell INPUT_ID... (at most %d)\n", CONTACTS_MAX);
        return EXIT_FAILURE;
    }
    if (chaincell_version() != CHAINCELL_VERSION) {
        fprintf(stderr, "press: header and library are of different versions\n");
        return EXIT_FAILURE;
    }
    for (at = 2; at < argc; at++) {
        char *end;
        const unsigned long id = strtoul(argv[at], &end, 10);

        if (argv[at][0] < '0' || argv[at][0] > '9' || *end != '\0' || id != (uint32_t)id) {
            fprintf(stderr, "press: %s: an input id is a whole number, 0 to 4294967295\n", argv[at]);
            return EXIT_FAILURE;
        }
        ids[count++] = (uint32_t)id;
    }
    image = read_image(argv[1], &bytes, &whole);
    if (image == NULL) {
        fprintf(stderr, "press: cannot read %s\n", argv[1]);
    } else {
        code = chaincell_model_init(&model, image, bytes, &detail);
        if (!refused(argv[1], code, &detail)) {
            status = run(&model, ids, count);
        }
    }
    free(whole);
    return status;
}
