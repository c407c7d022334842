"""Example 2: two tools in one message. Both press for half a second; then the second one turns.

`chaincell serve box.chaincell --tool sphere:0.008 --tool box:0.008,0.008,0.002,0.004 --scene left`
runs meanwhile, of a body of `--young-pa`; then `python two_tools.py left`.
"""

import sys

from chaincell import Rate, Session

WAIT_S = 1.0
"""A device's loop waits for less than a millisecond."""
TOP_M = 0.04
"""Where the surface of the body is."""

# The tissue's own forces, however late they are. For a device leave both at 20 ms.
with Session(sys.argv[1], watchdog_ms=0, ramp_ms=0) as session:
    for tick in Rate(1000, ticks=1000):
        z_m = TOP_M + 0.003 - 0.005 * min(tick / 500, 1.0)
        # A turn about x: t is the tangent of a quarter of its angle.
        t = 0.05 * max(tick / 500 - 1.0, 0.0)
        sin, cos = 2.0 * t / (1.0 + t * t), (1.0 - t * t) / (1.0 + t * t)
        engaged = tick > 0  # first released
        sphere = [-0.015, 0, z_m + 0.008, 0, 0, 0, 1]
        plate = [0.015, 0, z_m + 0.006, sin, 0, 0, cos]
        session.step([sphere, plate], engaged, timeout_s=WAIT_S)
        answer = session.answer
        assert answer is not None
        if tick % 250 == 249:
            print(f"tick {answer.tick}: state hash {answer.state_hash}")
            for number in range(2):
                x, y, z = answer.force_n[number]
                print(f"  tool {number}: force {x:.9f} {y:.9f} {z:.9f} N")
                x, y, z = answer.torque_n_m[number]
                print(f"  tool {number}: torque {x:.9f} {y:.9f} {z:.9f} N m")
