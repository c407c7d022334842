"""How long a follower takes from its start until it is within 50 ticks of the session.

    late.py TRACE FOLLOWED COMMAND ...

Starts the command, which follows TRACE, writes FOLLOWED, and goes on when this program ends; what it prints is in
FOLLOWED.said. Both traces have no tools, so that a tick is a record. Exits with 1 after more than two seconds.
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


def main():
    source, followed = Count(sys.argv[1]), None
    print(f"joins {source.now()} records late")
    begin = time.monotonic()
    subprocess.Popen(sys.argv[3:], stdout=open(f"{sys.argv[2]}.said", "wb"), start_new_session=True)
    while (now_s := time.monotonic() - begin) < LIMIT_S:
        if followed is None:
            try:
                followed = Count(sys.argv[2])
            except (FileNotFoundError, struct.error):
                pass
        elif tick(source) - tick(followed) <= WITHIN_TICKS:
            break
        time.sleep(0.002)
    print(f"within {WITHIN_TICKS} ticks {now_s:.2f} s after its start")
    sys.exit(now_s > MADE_UP_S)


if __name__ == "__main__":
    main()
