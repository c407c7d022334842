"""Example 3: plays a file of poses, `tick,x_m,y_m,z_m,engaged` line by line, as `chaincell run` writes
it.

`chaincell run plane.chaincell --contact 40 --motion press --seconds 2 --out offline` writes
offline/path.csv, and `chaincell serve plane.chaincell --contact 40 --scene left --record left.trace`
runs meanwhile; then `python replay.py left offline/path.csv`.
"""

import sys

from chaincell import Rate, Session

WAIT_S = 1.0
"""A device's loop waits for less than a millisecond."""

with open(sys.argv[2]) as file:
    lines = file.read().splitlines()[1:]
# The tissue's own forces, however late they are. For a device leave both at 20 ms.
with Session(sys.argv[1], watchdog_ms=0, ramp_ms=0) as session:
    # A tool has no force until a pose has released it once.
    session.step([0, 0, 0], False, timeout_s=WAIT_S)
    for tick in Rate(1000, ticks=len(lines)):
        _, x, y, z, engaged = lines[tick].split(",")
        force_n = session.step([float(x), float(y), float(z)], engaged == "1", timeout_s=WAIT_S)
        answer = session.answer
        assert answer is not None
        if tick % 500 == 499:
            print(f"row {tick}: state hash {answer.state_hash}")
            x_n, y_n, z_n = force_n
            print(f"  force {x_n:.9f} {y_n:.9f} {z_n:.9f} N")
