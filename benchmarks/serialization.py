"""How long a message takes as CDR bytes and back, by the codec: one of pressures, twelve numbers and a stamp.

python benchmarks/serialization.py [--messages 20000]
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from rclpy.serialization import deserialize_message, serialize_message

from forest_msgs_py.interfaces.definitions import message_definition
from forest_msgs_py.interfaces.messages import float_array
from forest_msgs_py.interfaces.topics import PRESSURES, message_class
from forest_msgs_py.serialization.batch_encoder import Encoder
from forest_msgs_py.serialization.cdr import cdr_type
from forest_msgs_py.serialization.packing import Packer
from forest_msgs_py.serialization.unpacking import ArrayReader

TYPE = PRESSURES.type


def mcap_ros2_decoder() -> Callable[[bytes], Any]:
    """Return what mcap-ros2-support decodes the type with."""
    schema = Schema(1, message_definition(TYPE).encode(), "ros2msg", TYPE)
    decoder = DecoderFactory().decoder_for("cdr", schema)
    assert decoder is not None
    return decoder


def measured(count: int) -> dict[str, tuple[float, float]]:
    """Return the processor time to encode and to decode a message [µs], NaN for none, by codec."""
    stamps = 5_000_000 * np.arange(count)
    values = np.random.default_rng(1).normal(size=(count, len(PRESSURES.labels)))
    messages = [
        float_array(PRESSURES, stamp, row)
        for stamp, row in zip(stamps.tolist(), values.tolist(), strict=True)
    ]
    kind, cdr, batch = message_class(PRESSURES), cdr_type(TYPE), Encoder(PRESSURES)
    packer, reader, peer = Packer(PRESSURES), ArrayReader(PRESSURES), mcap_ros2_decoder()
    data = [cdr.encode(message) for message in messages]
    assert batch.encode(stamps, values) == data  # the same bytes
    numbers = list(zip(stamps.tolist(), values.tolist(), strict=True))

    def each(act: Callable[[Any], Any], items: list[Any]) -> float:
        return timed(lambda: [act(item) for item in items], count)

    return {
        "batch": (
            timed(lambda: batch.encode(stamps, values), count),
            timed(lambda: batch.decode(data), count),
        ),
        "packing": (
            each(lambda one: packer.pack(*one), numbers),
            each(lambda one: reader.read(one, 0), data),
        ),
        "rosbags": (each(cdr.encode, messages), each(cdr.decode, data)),
        "rclpy": (each(serialize_message, messages), each(lambda one: deserialize_message(one, kind), data)),
        "mcap-ros2-support": (float("nan"), each(peer, data)),
    }


def timed(act: Callable[[], Any], count: int) -> float:
    """Return the processor time for each of so many messages [µs]."""
    begin = time.process_time()
    act()
    return 1e6 * (time.process_time() - begin) / count


def main() -> None:
    """Print a line for each codec."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--messages", type=int, default=20_000, metavar="N", help="default: 20000")
    print(f"{'codec':20} {'encode [µs]':>12} {'decode [µs]':>12}")
    for name, (encode, decode) in measured(parser.parse_args().messages).items():
        print(f"{name:20} {encode:12.1f} {decode:12.1f}")


if __name__ == "__main__":
    main()
