"""How far a followed trace is behind the one that it follows, while both are written.

    lag.py TRACE FOLLOWED SECONDS LINK [CUT_AT_S,CUT_S ...]

Both have the same header, and no tools, so that a tick is a record. Cuts the link of the process LINK, a `link.py`, at
these times. Prints the lag in ticks outside of the cuts and of two seconds after each, and how long after the end of
each cut it took to be within 50 ticks. Exits with 1 where that was more than two seconds.
"""

import os
import signal
import struct
import sys
import time

RECORD_BYTES = 48
STEP_S = 0.005
WITHIN_TICKS = 50
MADE_UP_S = 2.0


class Count:
    """Counts the records of a growing trace."""

    def __init__(self, path):
        self.file = open(path, "rb", buffering=0)  # it grows
        (self.header_bytes,) = struct.unpack("<I", self.file.read(16)[12:])
        self.count = 0

    def has(self, index):
        """True once the record is there."""
        self.file.seek(self.header_bytes + index * RECORD_BYTES + RECORD_BYTES - 4)
        seal = self.file.read(4)
        return len(seal) == 4 and seal != bytes(4)

    def now(self):
        # Steps that double while the records are there, then halve.
        step = 1
        while self.has(self.count + step - 1):
            self.count += step
            step *= 2
        while step > 1:
            step //= 2
            if self.has(self.count + step - 1):
                self.count += step
        return self.count


def main():
    source, followed = Count(sys.argv[1]), Count(sys.argv[2])
    seconds, link = float(sys.argv[3]), int(sys.argv[4])
    cuts = [tuple(map(float, cut.split(","))) for cut in sys.argv[5:]]
    begin, lags, made_up, is_cut = time.monotonic(), [], [], False
    # Cuts that have begun, and the time since the last one was mended.
    begun, mended_s = 0, float("-inf")
    try:
        while (now_s := time.monotonic() - begin) < seconds:
            if is_cut != any(at_s <= now_s < at_s + length_s for at_s, length_s in cuts):
                is_cut = not is_cut
                os.kill(link, signal.SIGUSR1 if is_cut else signal.SIGUSR2)
                begun, mended_s = (begun + 1, mended_s) if is_cut else (begun, now_s)
            behind = followed.now()
            lag = source.now() - behind
            if not is_cut and len(made_up) < begun and lag <= WITHIN_TICKS:
                made_up.append(now_s - mended_s)
            if not is_cut and now_s > mended_s + MADE_UP_S:
                lags.append(lag)
            time.sleep(STEP_S)
    finally:
        os.kill(link, signal.SIGUSR2)
    lags.sort()
    at = lambda share: lags[min(len(lags) - 1, int(share * len(lags)))]
    print(f"lag p50 {at(0.5)}, p99 {at(0.99)}, max {lags[-1]} ticks of {source.now()}")
    for number, span_s in enumerate(made_up, 1):
        print(f"cut {number} made up {span_s:.2f} s after its end")
    late = [span_s for span_s in made_up if span_s > MADE_UP_S]
    if late or len(made_up) < len(cuts):
        sys.exit(f"lag: of {len(cuts)} cuts {len(cuts) - len(made_up)} were not made up, {len(late)} late: {late} s")


if __name__ == "__main__":
    main()
