"""The binary message of a page's hands: what it says, and what is refused by name."""

import math
import random
import struct

import pytest

from forest_station.operator.hands_message import Hands, HandsError, decode_hands, encode_hands

BYTES, AXES, BUTTONS = 48, 6, 21
AXIS_AT, BUTTONS_AT, TIME_AT = 16, 40, 8


def single(value):
    """The value as the message's 32 bits hold it."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def any_hands(rng):
    return Hands(
        held=rng.random() < 0.5,
        number=rng.randrange(2**32),
        sent=rng.uniform(0.0, 1e6),
        axes=tuple(single(rng.choice((-1.0, 0.0, 1.0, rng.uniform(-1.0, 1.0)))) for _ in range(AXES)),
        buttons=rng.randrange(2**BUTTONS),
        pong=rng.randrange(2**32),
    )


def with_bytes(place, replacement):
    data = bytearray(encode_hands(Hands(True, 7, 1.0, (0.0,) * AXES, 0, 3)))
    data[place : place + len(replacement)] = replacement
    return bytes(data)


def test_what_is_encoded_is_decoded():
    rng = random.Random(1)
    for _ in range(500):
        hands = any_hands(rng)
        told = decode_hands(encode_hands(hands))
        assert told._replace(sent=hands.sent) == hands
        assert told.sent == pytest.approx(hands.sent, rel=1e-12)


def test_the_layout_is_that_of_the_protocol():
    data = struct.pack("<BBHId6fII", 1, 1, 0, 5, 2500.0, 0.5, -0.5, 0.0, 1.0, -1.0, 0.25, 0b1001, 4)
    assert decode_hands(data) == Hands(True, 5, 2.5, (0.5, -0.5, 0.0, 1.0, -1.0, 0.25), 0b1001, 4)


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (b"", "0 bytes"),
        (with_bytes(0, b"")[:-1], "47 bytes"),
        (with_bytes(0, b"") + b"\0", "49 bytes"),
        (with_bytes(0, b"\2"), "begins with 2"),
        (with_bytes(1, b"\2"), "begins with 1, 2"),
        (with_bytes(2, b"\1"), "begins with 1, 1, 1"),
        (with_bytes(TIME_AT, struct.pack("<d", math.nan)), "time is nan"),
        (with_bytes(TIME_AT, struct.pack("<d", math.inf)), "time is inf"),
        (with_bytes(AXIS_AT, struct.pack("<f", math.nan)), "axes are (nan"),
        (with_bytes(AXIS_AT, struct.pack("<f", 1.0001)), "axes are (1.0"),
        (with_bytes(AXIS_AT, struct.pack("<f", -1.0001)), "axes are (-1.0"),
        (with_bytes(AXIS_AT + 20, struct.pack("<f", -math.inf)), "-inf)"),
        (with_bytes(BUTTONS_AT, struct.pack("<I", 2**BUTTONS)), "buttons are 0x200000"),
    ],
)
def test_what_is_not_allowed_is_refused_by_name(data, named):
    with pytest.raises(HandsError, match="allowed") as refused:
        decode_hands(data)
    assert named in str(refused.value)


def test_random_bytes_are_read_or_refused_never_more():
    rng = random.Random(2)
    refused = 0
    for _ in range(3000):
        data = rng.randbytes(rng.choice((0, 1, 47, BYTES, BYTES, BYTES, 49, 500)))
        try:
            hands = decode_hands(data)
        except HandsError:
            refused += 1
            continue
        assert all(-1.0 <= axis <= 1.0 for axis in hands.axes)
    assert refused > 2900
