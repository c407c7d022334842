"""A bad link between two network namespaces: two TUN devices and a loop that delays and drops packets.

    link.py NAMESPACE NAMESPACE DELAY_MS LOSS_PERCENT

The addresses are 10.78.1.1 and 10.78.1.2. SIGUSR1 cuts the link, SIGUSR2 mends it. Needs root and iproute2.
"""

import ctypes
import fcntl
import heapq
import os
import random
import select
import signal
import struct
import subprocess
import sys
import time

CLONE_NEWNET = 0x40000000
TUNSETIFF = 0x400454CA
IFF_TUN_NO_PI = 0x1001
PACKET_BYTES = 2000


def tun(namespace, address):
    """The descriptor of a new TUN device in a namespace."""
    libc = ctypes.CDLL(None, use_errno=True)
    home = os.open("/proc/self/ns/net", os.O_RDONLY)
    there = os.open(f"/run/netns/{namespace}", os.O_RDONLY)
    if libc.setns(there, CLONE_NEWNET) != 0:
        raise OSError(ctypes.get_errno(), f"cannot enter the namespace {namespace}")
    device = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH", b"bad0", IFF_TUN_NO_PI))
    subprocess.run(["ip", "addr", "add", address, "dev", "bad0"], check=True)
    subprocess.run(["ip", "link", "set", "bad0", "up", "mtu", "1400", "txqueuelen", "1000"], check=True)
    libc.setns(home, CLONE_NEWNET)
    return device


def main():
    first, second, delay_ms, loss_percent = sys.argv[1:]
    delay_s, loss = float(delay_ms) / 1e3, float(loss_percent) / 100
    devices = [tun(first, "10.78.1.1/24"), tun(second, "10.78.1.2/24")]
    is_whole = True

    def set_whole(is_now_whole):
        nonlocal is_whole
        is_whole = is_now_whole

    signal.signal(signal.SIGUSR1, lambda *_: set_whole(False))
    signal.signal(signal.SIGUSR2, lambda *_: set_whole(True))
    random.seed(1)
    queue, count = [], 0
    print("link up", flush=True)
    while True:
        wait_s = max(0, queue[0][0] - time.monotonic()) if queue else 0.5
        for device in select.select(devices, [], [], wait_s)[0]:
            while True:
                try:
                    packet = os.read(device, PACKET_BYTES)
                except BlockingIOError:
                    break
                count += 1
                if is_whole and random.random() >= loss:
                    to = devices[1 - devices.index(device)]
                    heapq.heappush(queue, (time.monotonic() + delay_s, count, to, packet))
        while queue and queue[0][0] <= time.monotonic():
            _, _, to, packet = heapq.heappop(queue)
            try:
                os.write(to, packet)
            except OSError:
                pass  # a full queue drops it


if __name__ == "__main__":
    main()
