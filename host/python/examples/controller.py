"""A controller at 1 kHz: presses for ten seconds and prints the force ten times a second."""

import sys

from chaincell import Rate, Session

with Session(sys.argv[1]) as session:
    for tick in Rate(1000, seconds=10):
        depth_m = 1e-6 * tick
        force_n = session.step([0, 0, -depth_m], engaged=tick > 0)
        if tick % 100 == 0:
            print(tick, force_n)
    print(session.answer)
