"""Messages as CDR bytes, the same ones every time: for bags of simulated runs, which shall be repeatable.

ROS' own serializer leaves whatever was in memory between the fields; here such gaps are zero. Little-endian
plain CDR (version 1): a number stands at a multiple of its size, counted from behind the four bytes of the
encapsulation; a string is its length with the closing zero, then its bytes; a sequence its length, then its
elements.
"""

from __future__ import annotations

import re
import struct
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


def to_cdr(message: Any) -> bytes:
    """The bytes of a message of any type.

    Raises:
        ValueError: a field is of a kind that no topic of ours has (a wide string or character).
    """
    out = bytearray()
    _write_fields(out, message)
    out += bytes(-len(out) % 4)  # as DDS pads its payloads
    return ENCAPSULATION + bytes(out)


def _write_fields(out: bytearray, message: Any) -> None:
    for name, kind in message.get_fields_and_field_types().items():
        _write(out, getattr(message, name), kind)


def _write(out: bytearray, value: Any, kind: str) -> None:
    if kind in FORMATS:
        _write_number(out, value, FORMATS[kind])
    elif kind.startswith("string"):
        data = value.encode()
        _write_number(out, len(data) + 1, "I")
        out += data + b"\x00"
    elif sequence := _SEQUENCE.match(kind):
        _write_number(out, len(value), "I")
        for element in value:
            _write(out, element, sequence[1])
    elif array := _ARRAY.match(kind):
        for element in value:
            _write(out, element, array[1])
    elif hasattr(value, "get_fields_and_field_types"):
        _write_fields(out, value)
    else:
        raise ValueError(
            f"{kind} cannot be encoded; allowed: {', '.join(FORMATS)}, string, and made of these"
        )


def _write_number(out: bytearray, value: Any, letter: str) -> None:
    out += bytes(-len(out) % struct.calcsize(letter))
    out += struct.pack(f"<{letter}", value)
