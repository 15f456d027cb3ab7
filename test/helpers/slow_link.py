"""A link between two network namespaces that delays, jitters and loses, where the kernel lacks netem.

`python slow_link.py HOST HOST [--delay S] [--jitter S] [--loss 0..1] [--seed N]` makes a TUN device `link0`
in each, and hands packets on until it is killed. A packet waits for delay + jitter × a number of 0 .. 1, so
that jitter lets packets overtake each other. `QUEUE` packets wait in a direction; more are lost.
"""

import argparse
import contextlib
import ctypes
import fcntl
import heapq
import os
import random
import select
import struct
import time
from pathlib import Path

from forest_bringup.process_priority import raise_priority

CLONE_NEWNET = 0x40000000  # of setns(2)
TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000  # of linux/if_tun.h
LONGEST, QUEUE = 65536, 2000  # bytes of a packet; packets


def device(host: str) -> int:
    """Make the TUN device of a namespace, and give its file."""
    libc = ctypes.CDLL(None, use_errno=True)
    with Path(f"/var/run/netns/{host}").open("rb") as space:
        if libc.setns(space.fileno(), CLONE_NEWNET):
            raise OSError(ctypes.get_errno(), f"namespace {host!r} cannot be entered")
    tun = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(tun, TUNSETIFF, struct.pack("16sH22s", b"link0", IFF_TUN | IFF_NO_PI, b""))
    return tun


def relay(ends: tuple[int, int], delay: float, jitter: float, loss: float, chance: random.Random) -> None:
    """Hand packets on, for ever."""
    waiting: dict[int, list[tuple[float, int, bytes]]] = {end: [] for end in ends}  # by where they go
    count = 0
    while True:
        due = min((packets[0][0] for packets in waiting.values() if packets), default=None)
        patience = None if due is None else max(0.0, due - time.monotonic())
        for end in select.select(ends, (), (), patience)[0]:
            with contextlib.suppress(OSError):  # the link is down, or all is read
                while packet := os.read(end, LONGEST):
                    goes = waiting[ends[end == ends[0]]]
                    if chance.random() >= loss and len(goes) < QUEUE:
                        count += 1
                        heapq.heappush(
                            goes, (time.monotonic() + delay + jitter * chance.random(), count, packet)
                        )
        now = time.monotonic()
        for end, packets in waiting.items():
            while packets and packets[0][0] <= now:
                with contextlib.suppress(OSError):  # the link is down: lost
                    os.write(end, heapq.heappop(packets)[2])


def main() -> None:
    """Make the link."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("hosts", nargs=2)
    for name in ("delay", "jitter", "loss"):
        parser.add_argument(f"--{name}", type=float, default=0.0)
    parser.add_argument("--seed", type=int, default=1)
    p = parser.parse_args()
    raise_priority(os.getpid())  # a wire does not wait for a processor
    ends = device(p.hosts[0]), device(p.hosts[1])
    print("up", flush=True)
    relay(ends, p.delay, p.jitter, p.loss, random.Random(p.seed))


if __name__ == "__main__":
    main()
