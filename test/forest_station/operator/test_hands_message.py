"""The binary message of a page's hands: what it says, and what is refused by name."""

import contextlib
import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st
from properties import spoilt

from forest_station.operator.hands_message import Hands, HandsError, decode_hands, encode_hands

BYTES, AXES, BUTTONS = 48, 6, 21
AXIS_AT, BUTTONS_AT, TIME_AT = 16, 40, 8


NUMBERS = st.integers(0, 2**32 - 1)
HANDS = st.builds(
    Hands,
    held=st.booleans(),
    number=NUMBERS,
    sent=st.floats(0.0, 1e6),
    axes=st.tuples(*[st.floats(-1.0, 1.0, width=32)] * AXES),
    buttons=st.integers(0, 2**BUTTONS - 1),
    pong=NUMBERS,
)
WILD = st.builds(
    lambda start, ms, axes, end: struct.pack("<BBHId6fII", *start, ms, *axes, *end),
    st.tuples(st.just(1), st.integers(0, 1), st.just(0), NUMBERS),
    st.floats(),
    st.tuples(*[st.floats(-1.0, 1.0, width=32)] * (AXES - 1), st.floats(width=32) | st.just(math.nan)),
    st.tuples(st.integers(0, 2**BUTTONS), NUMBERS),
)
GOOD = encode_hands(Hands(True, 7, 1.0, (0.0,) * AXES, 0, 3))


def with_bytes(place, replacement):
    data = bytearray(GOOD)
    data[place : place + len(replacement)] = replacement
    return bytes(data)


@given(HANDS)
def test_what_is_encoded_is_decoded(hands):
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


@given(spoilt(GOOD) | WILD)
def test_what_is_read_of_any_bytes_is_what_they_say_and_nothing_else_is_read(data):
    with contextlib.suppress(HandsError):
        hands = decode_hands(data)
        assert all(-1.0 <= axis <= 1.0 for axis in hands.axes)
        assert math.isfinite(hands.sent)
        again = encode_hands(hands)
        assert (data[:8], data[AXIS_AT:]) == (again[:8], again[AXIS_AT:])
