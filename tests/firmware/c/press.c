/* The firmware of host/BOARD.md: presses a body whose image lies next to the command, and prints the hash of
 * its state. */
#include "board.h"
#include "chaincell.h"

/* The cells of the body, and the input id that the tool holds. */
enum { CELLS = 144, HELD = 122 };

/* The image, where the kernel can read it: at a multiple of 16 bytes. */
__asm__(".pushsection .rodata.model, \"a\"\n"
        ".balign 16\n"
        ".global model_begin, model_end\n"
        "model_begin: .incbin \"body.chaincell\"\n"
        "model_end:\n"
        ".popsection\n");
extern const uint8_t model_begin[], model_end[];

CHAINCELL_ALIGNED static unsigned char storage[CHAINCELL_TISSUE_BYTES(CELLS, 1, 0)];
static chaincell_model model;

static void print_hash(uint64_t hash)
{
    char text[] = "state hash 0123456789abcdef\n";
    int digit;

    for (digit = 0; digit < 16; digit++) {
        text[11 + digit] = "0123456789abcdef"[hash >> (60 - 4 * digit) & 15];
    }
    say(text);
}

int press(void)
{
    static const uint32_t held[1] = {HELD};
    static const chaincell_room room = {.contacts = 1};
    const size_t bytes = (size_t)(model_end - model_begin);
    chaincell_settings settings;
    chaincell_tissue *tissue;
    uint64_t hash;
    int tick;

    if (chaincell_model_init(&model, model_begin, bytes, NULL) != CHAINCELL_CODE_OK ||
        chaincell_settings_default(&model, CHAINCELL_SCHEME_TRACK, &settings) != CHAINCELL_CODE_OK ||
        chaincell_tissue_init(storage, sizeof storage, &model, CHAINCELL_SCHEME_TRACK, &room, &settings,
                              &tissue, NULL) != CHAINCELL_CODE_OK ||
        chaincell_choose_contacts(tissue, held, 1, NULL) != CHAINCELL_CODE_OK) {
        return 0;
    }
    for (tick = 0; tick < 200; tick++) {
        /* On a board: sleep until the position interrupt, then read the encoders. */
        chaincell_tool_pose pose = {{0.0f, 0.0f, -(float)tick / 32768.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, 1, 0};
        chaincell_output output;

        if (chaincell_tick(tissue, &pose, 1, NULL, &output) != CHAINCELL_CODE_OK) {
            return 0;
        }
        /* On a board: output.tool.force_n to the amplifiers, through chaincell_stage. */
    }
    if (chaincell_state_hash(tissue, &hash) != CHAINCELL_CODE_OK) {
        return 0;
    }
    print_hash(hash);
    return 1;
}
