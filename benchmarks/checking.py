"""How long `forest-bag play` checks a bag before it plays: processor time per GB.

By size of message and compression. A message is half noise that repeats, half zeros.
The file is in the page cache: a slow disk comes on top.

    python benchmarks/checking.py [--megabytes 100]
"""

from __future__ import annotations

import argparse
import os
import random
import tempfile
import time
from pathlib import Path

from forest_bag.read.bag_reader import BagReader
from forest_bag.write.bag_split import Layout
from forest_bag.write.bag_writer import BagWriter

SIZES = (150, 1000, 20_000)  # bytes of a message
PERIOD_NS = 1_000_000


def write(directory: Path, size: int, compression: str, total: int) -> None:
    """Write a bag of so many bytes of messages."""
    writer = BagWriter(directory, Layout(compression))
    writer.add_topic("/a", "std_msgs/msg/String", [], "")
    noise = random.Random(1).randbytes(size // 2)
    for number in range(total // size):
        data = noise + os.urandom(8) + bytes(size - size // 2 - 8)
        writer.write("/a", data, number * PERIOD_NS, number * PERIOD_NS, number)
    writer.close()


def measure(directory: Path, total: int) -> tuple[float, float]:
    """Return processor time per GB of messages, and per GB of the file [s]."""
    begin = time.process_time()
    with BagReader(directory) as bag:
        bag.check()
        seconds = time.process_time() - begin
        return 1e9 * seconds / total, 1e9 * seconds / bag.size


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description="Processor time of the check before playing.")
    parser.add_argument("--megabytes", type=int, default=100, help="of messages in each bag")
    total = parser.parse_args().megabytes * 1_000_000
    print("| bytes of a message | compression | s per GB of messages | s per GB of file |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="forest-checking-") as folder:
        for size in SIZES:
            for compression in ("none", "zstd"):
                directory = Path(folder) / f"{size}_{compression}"
                write(directory, size, compression, total)
                per_messages, per_file = measure(directory, total)
                print(f"| {size} | {compression} | {per_messages:.1f} | {per_file:.1f} |", flush=True)


if __name__ == "__main__":
    main()
