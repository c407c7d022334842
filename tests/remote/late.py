"""How long a follower takes from its start until it is within 50 ticks of the session.

    late.py TRACE FOLLOWED COMMAND ...

Starts the command, which follows TRACE, writes FOLLOWED, and goes on until the session ends; what it prints is in
FOLLOWED.said. Both traces have no tools, so that a tick is a record. Prints how long it took, and exits with 1 after
more than two seconds, where the session stood still meanwhile, or where the command fails.
"""

import struct
import subprocess
import sys
import time

from lag import MADE_UP_S, RECORD_BYTES, WITHIN_TICKS, Count

LIMIT_S = 60.0


def tick(trace):
    """Number of the last recorded tick."""
    count = trace.now()
    if count == 0:
        return -1
    trace.file.seek(trace.header_bytes + (count - 1) * RECORD_BYTES)
    return struct.unpack("<Q", trace.file.read(8))[0]


def opened(path):
    """A trace, once its header is written."""
    try:
        count = Count(path)
    except (FileNotFoundError, struct.error):
        return None
    return count if count.header_bytes else None


def main():
    source, followed = Count(sys.argv[1]), None
    began_at, begin = source.now(), time.monotonic()
    print(f"joins {began_at} records late", flush=True)
    with open(f"{sys.argv[2]}.said", "wb") as said:
        follower = subprocess.Popen(sys.argv[3:], stdout=said)
    while (now_s := time.monotonic() - begin) < LIMIT_S:
        if followed is None:
            followed = opened(sys.argv[2])
        elif tick(source) - tick(followed) <= WITHIN_TICKS:
            break
        time.sleep(0.002)
    went_on = source.now() - began_at
    print(f"within {WITHIN_TICKS} ticks {now_s:.2f} s after its start; the session made {went_on} meanwhile", flush=True)
    code = follower.wait(LIMIT_S)
    sys.exit(now_s > MADE_UP_S or went_on < 0.5 * 1000 * now_s or code)


if __name__ == "__main__":
    main()
