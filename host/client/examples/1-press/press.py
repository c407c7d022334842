"""Example 1: presses a served tissue for half a second, holds it as long, and lets go.

`chaincell serve plane.chaincell --contact 40 --scene left` runs meanwhile; then `python press.py left`.
"""

import math
import sys

from chaincell import Rate, Session

WAIT_S = 1.0
"""A device's loop waits for less than a millisecond."""

# The tissue's own forces, however late they are. For a device leave both at 20 ms.
with Session(sys.argv[1], watchdog_ms=0, ramp_ms=0) as session:
    largest_n = 0.0
    answers = 0
    for tick in Rate(1000, ticks=1500):
        depth_m = 0.02 * min(tick / 500, 1.0)
        # A tool has no force until a pose has released it once.
        engaged = 0 < tick <= 1000
        force_n = session.step([0, 0, -depth_m], engaged, timeout_s=WAIT_S)
        x, y, z = force_n.tolist()  # what a device shows now
        largest_n = max(largest_n, math.sqrt(x * x + y * y + z * z))
        answer = session.answer
        assert answer is not None
        answers = answer.answers
        if tick in (1000, 1499):
            print(f"tick {answer.tick}: state hash {answer.state_hash}")
    print(f"{answers} answers, largest force {largest_n:.9f} N")
