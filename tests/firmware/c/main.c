/* A body in a microcontroller, through the C interface: the motion of kernel/ffi/examples/press.c,
 * tick by tick, and the state hash on the debugger's channel. */
#include "board.h"
#include "chaincell.h"

enum { CELLS = 125, HATS = 27, CONTACTS = 2, PRESS_TICKS = 200, TICKS = 250, PRINT_EVERY = 25 };

/* The model in flash, where an image may start. */
__asm__(".pushsection .rodata.model, \"a\"\n"
        ".balign 16\n"
        ".global model_begin, model_end\n"
        "model_begin: .incbin \"" MODEL "\"\n"
        "model_end:\n"
        ".popsection\n");
extern const uint8_t model_begin[], model_end[];

/* The body in RAM, sized where it is compiled. */
CHAINCELL_ALIGNED static unsigned char storage[CHAINCELL_TISSUE_BYTES(CELLS, CONTACTS, HATS)];
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
    static const uint32_t ids[CONTACTS] = {64, 69};
    const size_t bytes = (size_t)(model_end - model_begin);
    chaincell_settings settings;
    chaincell_tissue *tissue = NULL;

    if (is_done("model", chaincell_model_init(&model, model_begin, bytes, NULL)) &&
        is_done("settings",
                chaincell_settings_default(&model, CHAINCELL_SCHEME_TRACK, &settings)) &&
        is_done("tissue", chaincell_tissue_init(storage, sizeof storage, &model,
                                                CHAINCELL_SCHEME_TRACK, CONTACTS, &settings,
                                                &tissue, NULL)) &&
        is_done("contacts", chaincell_choose_contacts(tissue, ids, CONTACTS, NULL))) {
        return tissue;
    }
    return NULL;
}

int press(void)
{
    chaincell_tissue *tissue = begin();
    chaincell_sample sample = {{0.0f, 0.0f, 0.0f}, 0};
    chaincell_output output;
    union {
        float real;
        uint32_t bits;
    } force_n;
    uint64_t hash;
    uint32_t tick;

    if (tissue == NULL) {
        return 0;
    }
    for (tick = 0; tick < TICKS; tick++) {
        sample.position_m[2] = -0.0001f * (float)tick;
        sample.engaged = tick < PRESS_TICKS;
        if (!is_done("tick", chaincell_tick(tissue, &sample, &output))) {
            return 0;
        }
        if (tick % PRINT_EVERY == PRINT_EVERY - 1) {
            force_n.real = output.force_n[2];
            say_hexadecimal("force bits ", force_n.bits);
        }
    }
    if (!is_done("hash", chaincell_state_hash(tissue, &hash))) {
        return 0;
    }
    say_hexadecimal("state hash ", hash);
    return 1;
}
