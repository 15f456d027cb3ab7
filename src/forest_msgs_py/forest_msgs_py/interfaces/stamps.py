"""The stamp of a message in its CDR bytes, without decoding the rest.

Offsets count from behind the four bytes of the encapsulation; see :mod:`forest_msgs_py.serialization.cdr`.
"""

import struct

from forest_msgs_py.interfaces.topics import FLOAT_ARRAY, JOINT_STATE, JOY_TYPE, POSE, TWIST
from forest_msgs_py.types import NS_PER_S

MOST_STAMP = 2**32  # seconds, or nanoseconds

FIRST = 4  # bytes of the encapsulation
STAMPED = frozenset(
    (
        *(FLOAT_ARRAY, JOINT_STATE, JOY_TYPE, POSE, TWIST),
        *("diagnostic_msgs/msg/DiagnosticArray", "rosgraph_msgs/msg/Clock", "std_msgs/msg/Header"),
    )
)
NO_STAMP = -1


def stamp_in(type_name: str, data: bytes) -> int:
    """The stamp of a message of one of the `STAMPED` types [ns]; `NO_STAMP` where an array carries none."""
    if type_name != FLOAT_ARRAY:
        sec, nanosec = struct.unpack_from("<iI", data, FIRST)
        return int(sec) * NS_PER_S + int(nanosec)
    place = after_dimensions(data)
    offset, count = struct.unpack_from("<II", data, place)
    if offset != 2 or count < 2:
        return NO_STAMP
    place = FIRST + aligned(place + 8 - FIRST, 8)
    seconds, nanoseconds = struct.unpack_from("<dd", data, place)
    return int(seconds) * NS_PER_S + int(nanoseconds)


def after_dimensions(data: bytes) -> int:
    """Where the layout's data_offset stands."""
    (dimensions,) = struct.unpack_from("<I", data, FIRST)
    place = FIRST + 4
    for _ in range(dimensions):
        (length,) = struct.unpack_from("<I", data, place)
        place = FIRST + aligned(place + 4 + length - FIRST, 4) + 8  # label, then size and stride
    return place


def aligned(place: int, size: int) -> int:
    """The next multiple of a size."""
    return place + -place % size
