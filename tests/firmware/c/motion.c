/* The motion of the golden scenes, operation by operation that of tests/scenes/src/motion.rs; and the
 * digest of tests/scenes/src/digest.rs: CRC-64/XZ over all that the ticks answer. */
#include "golden.h"

enum { STROKE = 50 };

static const float ways[4][3] = {
    {0.0f, 0.0f, -1.0f}, {0.6f, 0.0f, -0.8f}, {0.0f, -0.6f, 0.8f}, {0.3f, 0.2f, -1.0f}};

static float part(uint32_t at, uint32_t from, uint32_t to)
{
    const uint32_t inside = at < from ? from : at > to ? to : at;

    return (float)(inside - from) / (float)(to - from);
}

chaincell_tool_pose golden_pose(float reach_m, uint32_t tick)
{
    const uint32_t stroke = tick / STROKE, at = tick % STROKE, hundreds = tick % 400;
    const float far = stroke % 8 == 5 ? 20.0f : 1.0f;
    const float depth = (part(at, 0, 16) - 0.5f * part(at, 28, 36)) * far * reach_m;
    const float aside = 0.5f * part(at, 16, 28) * reach_m;
    const float *way = ways[stroke % 4];
    const int long_gap = hundreds >= 66 && hundreds < 80;
    const union {
        uint32_t bits;
        float real;
    } not_a_number = {0x7fc00000u};
    chaincell_tool_pose pose = {{0.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f, 1.0f}, 0, 0};

    pose.position_m[0] = 0.25f + way[0] * depth;
    pose.position_m[1] = way[1] * depth + aside;
    pose.position_m[2] = way[2] * depth;
    pose.engaged = at < 36;
    if (tick % 61 == 30 || (long_gap && tick % 2 == 0)) {
        pose.position_m[1] = not_a_number.real;
    } else if (long_gap) {
        pose.engaged = 2;
    }
    return pose;
}

static uint64_t absorb(uint64_t crc, uint64_t value, int bytes)
{
    int bit;

    for (; bytes > 0; bytes--, value >>= 8) {
        crc ^= value & 255;
        for (bit = 0; bit < 8; bit++) {
            crc = crc >> 1 ^ (crc & 1 ? 0xC96C5795D7870F42u : 0);
        }
    }
    return crc;
}

uint64_t golden_absorb(uint64_t digest, uint64_t state_hash, const chaincell_output *output)
{
    union {
        float real;
        uint32_t bits;
    } number;
    uint64_t crc = absorb(~digest, state_hash, 8);
    int axis;

    for (axis = 0; axis < 3; axis++) {
        number.real = output->tool.force_n[axis];
        crc = absorb(crc, number.bits, 4);
    }
    number.real = output->energy_j;
    crc = absorb(crc, number.bits, 4);
    crc = absorb(crc, output->tool.contacts, 4);
    return ~absorb(crc, output->tool.flags, 4);
}
