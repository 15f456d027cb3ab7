"""Messages as CDR bytes, the same ones every time: for bags of simulated runs, which shall be repeatable.

ROS' own serializer leaves whatever was in memory between the fields; here such gaps are zero. Little-endian
plain CDR (version 1): a number stands at a multiple of its size, counted from behind the four bytes of the
encapsulation; a string is its length with the closing zero, then its bytes; a sequence its length, then its
elements.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from functools import cache
from operator import attrgetter
from typing import Any

ENCAPSULATION = b"\x00\x01\x00\x00"
# fmt: off
FORMATS = {
    "boolean": "?", "octet": "c", "uint8": "B", "int8": "b", "uint16": "H", "int16": "h",
    "uint32": "I", "int32": "i", "uint64": "Q", "int64": "q", "float": "f", "double": "d",
}
# fmt: on
_SEQUENCE = re.compile(r"sequence<(.+?)(?:, \d+)?>$")
_ARRAY = re.compile(r"(.+)\[\d+\]$")


Write = Callable[[bytearray, Any], None]


def to_cdr(message: Any) -> bytes:
    """The bytes of a message of any type.

    Raises:
        ValueError: a field is of a kind that no topic of ours has (a wide string or character).
    """
    out = bytearray()
    _write_message(out, message)
    out += bytes(-len(out) % 4)  # as DDS pads its payloads
    return ENCAPSULATION + bytes(out)


@cache
def _fields_writer(message_type: Any) -> Write:
    """Writes the fields of a message type; looking up how takes longer than writing, so it is done once."""
    kinds = message_type.get_fields_and_field_types()
    fields = [(attrgetter(name), _writer(kind)) for name, kind in kinds.items()]

    def write(out: bytearray, message: Any) -> None:
        for value_of, write_field in fields:
            write_field(out, value_of(message))

    return write


@cache
def _writer(kind: str) -> Write:
    """Writes a field of a kind, as its message type names it."""
    if kind in FORMATS:
        return _number_writer(FORMATS[kind])
    if kind.startswith("string"):
        return _write_string
    if sequence := _SEQUENCE.match(kind):
        return _elements_writer(sequence[1], counted=True)
    if array := _ARRAY.match(kind):
        return _elements_writer(array[1], counted=False)
    if "/" not in kind:
        raise ValueError(
            f"{kind} cannot be encoded; allowed: {', '.join(FORMATS)}, string, and made of these"
        )
    return _write_message


def _write_message(out: bytearray, message: Any) -> None:
    kind: Any = type(message)
    _fields_writer(kind)(out, message)


def _number_writer(letter: str) -> Write:
    packer = struct.Struct(f"<{letter}")
    size = packer.size

    def write(out: bytearray, value: Any) -> None:
        if gap := -len(out) % size:
            out += bytes(gap)
        out += packer.pack(value)

    return write


_write_length = _number_writer("I")


def _write_string(out: bytearray, value: str) -> None:
    data = value.encode()
    _write_length(out, len(data) + 1)
    out += data + b"\x00"


def _elements_writer(kind: str, counted: bool) -> Write:
    if kind in FORMATS:
        return _numbers_writer(FORMATS[kind], counted)
    write_element = _writer(kind)

    def write(out: bytearray, values: Any) -> None:
        if counted:
            _write_length(out, len(values))
        for value in values:
            write_element(out, value)

    return write


def _numbers_writer(letter: str, counted: bool) -> Write:
    size = struct.calcsize(letter)

    def write(out: bytearray, values: Any) -> None:
        count = len(values)
        if counted:
            _write_length(out, count)
        if count == 0:
            return
        out += bytes(-len(out) % size)
        out += struct.pack(f"<{count}{letter}", *values)

    return write
