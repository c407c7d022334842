// The force of a device: off on any doubt, along a ramp, and on again after a calm while. For loops of 1 kHz.
#ifndef CHAINCELL_DEVICE_GUARD_HPP
#define CHAINCELL_DEVICE_GUARD_HPP

#include <algorithm>
#include <cmath>

#include "chaincell_client.h"

class DeviceGuard {
public:
    // Largest force on the hand [N].
    explicit DeviceGuard(double max_force_n) : max_force_n(max_force_n) {}

    // Takes the device's position [m], once a period; `is_read` is false where the device reported an error. Returns
    // false on a doubt: the pose must not be used then.
    bool position(bool is_read, const double (&position_m)[3])
    {
        double square = 0.0;
        bool is_near = is_read;
        for (int axis = 0; axis < 3; ++axis) {
            is_near = is_near && std::abs(position_m[axis]) <= REACH_M; // false where it is no number
            square += (position_m[axis] - last_m[axis]) * (position_m[axis] - last_m[axis]);
        }
        const bool is_jump = has_last && is_near && std::sqrt(square) > JUMP_M;
        if (is_near) {
            std::copy(position_m, position_m + 3, last_m);
            has_last = true;
        }
        const bool is_good = judge(is_near && !is_jump);
        is_engaged = is_engaged || (is_good && !is_stopped && share == 0 && calm >= CALM);
        return is_good;
    }

    // Takes what a call of the client came to, once a period.
    void answer(chaincell_client_code code, const chaincell_client_answer &answer)
    {
        const unsigned old = CHAINCELL_CLIENT_NOTE_NOTHING_YET | CHAINCELL_CLIENT_NOTE_SILENT | CHAINCELL_CLIENT_NOTE_NEW_SESSION;
        judge(code >= 0 && (answer.notes & old) == 0);
    }

    // True while the tool acts on the tissue.
    bool engaged() const { return is_engaged; }

    // Gives the force to show [N], once a period; `tissue_n` is that of the last answer on the axes of the device.
    void force(const double (&tissue_n)[3], double (&shown_n)[3])
    {
        if (is_engaged) {
            const double size_n = std::sqrt(tissue_n[0] * tissue_n[0] + tissue_n[1] * tissue_n[1] + tissue_n[2] * tissue_n[2]);
            const double factor = size_n > max_force_n ? max_force_n / size_n : 1.0;
            for (int axis = 0; axis < 3; ++axis) {
                target_n[axis] = std::isfinite(size_n) ? factor * tissue_n[axis] : 0.0;
            }
        }
        share = std::clamp(share + (is_engaged ? 1 : -1), 0, RAMP_PERIODS);
        double square = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            shown_n[axis] = target_n[axis] * share / RAMP_PERIODS;
            square += shown_n[axis] * shown_n[axis];
        }
        largest_n = std::max(largest_n, std::sqrt(square));
    }

    // From here on the force falls and stays off.
    void stop() { is_stopped = true, is_engaged = false; }

    // True once a stopped force is 0.
    bool is_off() const { return is_stopped && share == 0; }

    // Number of doubts that lowered a force, and the largest force so far [N].
    int doubts = 0;
    double largest_n = 0.0;

private:
    static constexpr double REACH_M = 1.0;  // farther from its zero is no device
    static constexpr double JUMP_M = 0.008; // in a period: 8 m/s, faster than a hand
    static constexpr int CALM = 200;        // good positions and answers in a row before the tool engages
    static constexpr int RAMP_PERIODS = 10;

    bool judge(bool is_good)
    {
        calm = is_good ? std::min(calm + 1, CALM) : 0;
        doubts += !is_good && is_engaged;
        is_engaged = is_engaged && is_good;
        return is_good;
    }

    const double max_force_n;
    bool is_engaged = false, is_stopped = false, has_last = false;
    int calm = 0, share = 0;
    double last_m[3] = {}, target_n[3] = {};
};

#endif
