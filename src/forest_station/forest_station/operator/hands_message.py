"""The message in which a page tells what the operator's hands do: 48 bytes, little-endian.

| offset | type | content |
|---|---|---|
| 0 | u8 | 1: hands |
| 1 | u8 | bit 0: the deadman is held |
| 2 | u16 | zero |
| 4 | u32 | number, one more than the last |
| 8 | f64 | the page's monotonic time [ms] |
| 16 | f32[6] | axes as in `/joy`, from -1 to 1 |
| 40 | u32 | buttons as in `/joy`, bit by bit |
| 44 | u32 | number of the newest `pong` that the page has heard; 0: none |
"""

import math
import struct
from typing import NamedTuple

from forest_control.operator.levers import AXIS_COUNT, BUTTON_COUNT

KIND = 1
HELD = 1
LAYOUT = struct.Struct(f"<BBHId{AXIS_COUNT}fII")
MS_PER_S = 1000.0


class HandsError(ValueError):
    """A message is refused; the text names what is wrong and what is allowed."""


class Hands(NamedTuple):
    """What the operator's hands do."""

    held: bool  # the deadman
    number: int
    sent: float  # by the page's monotonic clock [s]
    axes: tuple[float, ...]  # -1 to 1, as in /joy
    buttons: int  # bit by bit
    pong: int  # number of the newest pong that the page has heard


def decode_hands(data: bytes) -> Hands:
    """Return what a message says.

    Raises:
        HandsError: it has another length, kind or padding, or a number is not allowed.
    """
    if len(data) != LAYOUT.size:
        raise HandsError(f"hands: {len(data)} bytes; allowed: {LAYOUT.size}")
    kind, flags, padding, number, sent, *rest = LAYOUT.unpack(data)
    axes, (buttons, pong) = tuple(rest[:AXIS_COUNT]), rest[AXIS_COUNT:]
    if kind != KIND or flags not in (0, HELD) or padding:
        raise HandsError(f"hands: begins with {kind}, {flags}, {padding}; allowed: {KIND}, 0 or {HELD}, 0")
    if not math.isfinite(sent):
        raise HandsError(f"hands: time is {sent}; allowed: a finite number of ms")
    if not all(-1.0 <= axis <= 1.0 for axis in axes):  # false for NaN as well
        raise HandsError(f"hands: axes are {axes}; allowed: -1 to 1")
    if buttons >> BUTTON_COUNT:
        raise HandsError(f"hands: buttons are {buttons:#x}; allowed: the lowest {BUTTON_COUNT} bits")
    return Hands(flags == HELD, number, sent / MS_PER_S, axes, buttons, pong)


def encode_hands(hands: Hands) -> bytes:
    """Return the message that says this."""
    start = (KIND, HELD * hands.held, 0, hands.number, hands.sent * MS_PER_S)
    return LAYOUT.pack(*start, *hands.axes, hands.buttons, hands.pong)
