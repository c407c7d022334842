// Presses a served tissue for a second at 1 kHz, and prints what came of it.
//
//   chaincell serve plane.chaincell --contact 40 --scene left
//   ./press left 0.01
//
// The number is the depth [m], along -z from the origin.
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "chaincell_client.h"
#ifdef WITH_KERNEL
#include "chaincell.h"
#endif

static_assert(sizeof(chaincell_client_options) == 24, "options are six words");
static_assert(sizeof(chaincell_client_pose) == 32, "a pose is eight words");
static_assert(sizeof(chaincell_client_answer) == 336, "an answer is twenty words and eight tools");
static_assert(sizeof(chaincell_client_node) == 16, "a node is four words");
static_assert(sizeof(chaincell_client_contact) == 52, "a contact is thirteen words");
static_assert(sizeof(chaincell_client_reply) == 32, "a reply is eight words");

namespace {

constexpr int TICKS = 1000;
constexpr std::uint64_t WAIT_NS = 900'000;

// Says why a call was refused.
int refused(const char *what, chaincell_client_code code)
{
    std::fprintf(stderr, "press: %s: %s (%s)\n", what, chaincell_client_last_error(),
                 chaincell_client_error_text(code));
    return EXIT_FAILURE;
}

double size_n(const chaincell_client_tool &tool)
{
    return std::hypot(tool.force_n[0], tool.force_n[1], tool.force_n[2]);
}

} // namespace

int main(int count, char **words)
{
    if (count != 3) {
        std::fprintf(stderr, "usage: press SCENE DEPTH_M\n");
        return 2;
    }
#ifdef WITH_KERNEL
    if (chaincell_version() != CHAINCELL_VERSION) {
        return 2;
    }
#endif
    const double depth_m = std::strtod(words[2], nullptr);
    chaincell_client client = 0;
    chaincell_client_code code =
        chaincell_client_open(CHAINCELL_CLIENT_VERSION, words[1], nullptr, &client);
    if (code != CHAINCELL_CLIENT_CODE_OK) {
        return refused(words[1], code);
    }

    double largest_n = 0.0;
    int silent = 0;
    chaincell_client_answer answer{};
    auto due = std::chrono::steady_clock::now();
    for (int tick = 0; tick < TICKS; ++tick) {
        // Down in the first half, held in the second; the first pose is released.
        const double down = std::fmin(1.0, 2.0 * tick / TICKS);
        chaincell_client_pose pose{};
        pose.position_m[2] = static_cast<float>(-depth_m * down);
        pose.orientation[3] = 1.0F;
        pose.engaged = tick > 0;
        code = chaincell_client_step(client, &pose, 1, WAIT_NS, &answer);
        if (code < 0) {
            return refused("step", code);
        }
        silent += code == CHAINCELL_CLIENT_CODE_SILENT;
        // Here a device would be given answer.tools[0].force_n.
        largest_n = std::fmax(largest_n, size_n(answer.tools[0]));
        due += std::chrono::milliseconds(1);
        std::this_thread::sleep_until(due);
    }
    // Those that are still on the way.
    for (int ms = 0; ms < 1000 && answer.tick < TICKS; ++ms) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        chaincell_client_try_receive(client, &answer);
    }
    std::printf("largest force %.9g N\n%llu answers to %d poses, %d steps without one\n", largest_n,
                static_cast<unsigned long long>(answer.answers), TICKS, silent);
    std::printf("state hash %016llx\n", static_cast<unsigned long long>(answer.state_hash));
    code = chaincell_client_close(client);
    return code == CHAINCELL_CLIENT_CODE_OK ? EXIT_SUCCESS : refused("close", code);
}
