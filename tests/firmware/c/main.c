/* A body in a microcontroller, through the C interface: the golden scene organ500_track, and its
 * digest on the debugger's channel. */
#include "board.h"
#include "chaincell.h"
#include "golden.h"

/* The scene of tests/scenes/src/list.rs. */
enum { CELLS = 499, COARSE = 24, CONTACTS = 7, SWEEPS = 4, TICKS = 100 };
static const uint32_t held[CONTACTS] = {415, 435, 436, 438, 439, 457, 477};
static const float reach_m = 0.06f;

/* The model in flash, where an image may start. */
__asm__(".pushsection .rodata.model, \"a\"\n"
        ".balign 16\n"
        ".global model_begin, model_end\n"
        "model_begin: .incbin \"" MODEL "\"\n"
        "model_end:\n"
        ".popsection\n");
extern const uint8_t model_begin[], model_end[];

/* The body in RAM, sized where it is compiled. */
CHAINCELL_ALIGNED static unsigned char storage[CHAINCELL_TISSUE_BYTES(CELLS, CONTACTS, COARSE)];
static chaincell_model model;

static void say_hexadecimal(const char *name, uint64_t value)
{
    char text[20];
    int at;

    for (at = 0; at < 16; at++) {
        text[at] = "0123456789abcdef"[value >> (60 - 4 * at) & 15];
    }
    text[16] = '\n';
    text[17] = '\0';
    say(name);
    say(text);
}

static int is_done(const char *what, chaincell_code code)
{
    if (code != CHAINCELL_CODE_OK) {
        say(what);
        say(": ");
        say(chaincell_code_text(code));
        say("\n");
    }
    return code == CHAINCELL_CODE_OK;
}

static chaincell_tissue *begin(void)
{
    static const chaincell_room room = {.contacts = CONTACTS};
    const size_t bytes = (size_t)(model_end - model_begin);
    chaincell_settings settings;
    chaincell_tissue *tissue = NULL;

    if (!is_done("model", chaincell_model_init(&model, model_begin, bytes, NULL)) ||
        !is_done("settings",
                 chaincell_settings_default(&model, CHAINCELL_SCHEME_TRACK, &settings))) {
        return NULL;
    }
    settings.sweeps = SWEEPS;
    settings.unloading = CHAINCELL_UNLOADING_RELEASE;
    if (is_done("tissue", chaincell_tissue_init(storage, sizeof storage, &model,
                                                CHAINCELL_SCHEME_TRACK, &room, &settings,
                                                &tissue, NULL)) &&
        is_done("contacts", chaincell_choose_contacts(tissue, held, CONTACTS, NULL))) {
        return tissue;
    }
    return NULL;
}

int press(void)
{
    chaincell_tissue *tissue = begin();
    chaincell_tool_pose pose;
    chaincell_output output;
    uint64_t hash = 0, digest = 0;
    uint32_t tick;

    if (tissue == NULL) {
        return 0;
    }
    for (tick = 0; tick < TICKS; tick++) {
        pose = golden_pose(reach_m, tick);
        if (!is_done("tick", chaincell_tick(tissue, &pose, 1, NULL, &output)) ||
            !is_done("hash", chaincell_state_hash(tissue, &hash))) {
            return 0;
        }
        digest = golden_absorb(digest, hash, &output);
    }
    say_hexadecimal("state hash ", hash);
    say_hexadecimal("digest ", digest);
    say_hexadecimal("stack bytes ", stack_bytes());
    return 1;
}
