"""Messages of any type as CDR bytes and back, by the type's definition: for templates and for bags.

rosbags' typestore does the work. The gaps between fields are zero, where ROS's own serializer leaves what
was in memory: a bag of a simulated run repeats to the byte.

rosbags and not mcap-ros2-support: that one takes twice as long to decode, encodes only into its own file,
and reads no IDL. What a node does in each step is in `packing` and `unpacking`, which are faster still
(`benchmarks/serialization.py`).
"""

import struct
from array import array
from functools import cache
from typing import Any

import numpy as np
from rosbags.serde import SerdeError
from rosbags.typesys import TypesysError, get_types_from_idl, get_types_from_msg
from rosbags.typesys.store import Typestore

from forest_msgs_py.interfaces.definitions import SEPARATOR, message_definition

ENCAPSULATION = b"\x00\x01\x00\x00"
_IDL = f"{SEPARATOR}\nIDL: "
# What rosbags raises over a definition, and over bytes, that make no sense.
_NO_DEFINITION = (TypesysError, KeyError, ValueError, TypeError, AssertionError, SyntaxError, RecursionError)
_NO_MESSAGE = (SerdeError, struct.error, ValueError, IndexError, MemoryError)


class CdrError(ValueError):
    """Bytes that are no message of their type."""


class CdrType:
    """Encodes and decodes the messages of one type.

    Args:
        name: like ``sensor_msgs/msg/JointState``.
        definition: of the type and of all types in it, in MCAP's form ``ros2msg`` or ``ros2idl``.

    Raises:
        ValueError: the definition is none, or holds a kind of field that rosbags does not know (wstring).
    """

    def __init__(self, name: str, definition: str) -> None:
        self._name, self._store = name, Typestore()
        try:
            self._store.register(_types(name, definition))
            self._layout = self._store.get_msgdef(name)
        except _NO_DEFINITION as error:
            raise ValueError(f"{name} has a definition that cannot be used: {error}") from error

    def encode(self, message: Any) -> bytes:
        """Return the bytes of one of ROS's messages, padded as DDS pads its payloads."""
        data = bytes(self._store.serialize_cdr(self._rebuilt(message), self._name, little_endian=True))
        return data + bytes(-len(data) % 4)

    def decode(self, data: bytes) -> Any:
        """Return a message, a dataclass of rosbags', whose arrays are numpy's.

        More than the message may follow it: ROS's serializer leaves some bytes unused at the end.

        Raises:
            CdrError: the bytes are no such message.
        """
        layout = self._layout
        read = layout.deserialize_cdr_le if data[1:2] == b"\x01" else layout.deserialize_cdr_be
        try:
            message, _end = read(memoryview(data)[len(ENCAPSULATION) :], 0, layout.cls, self._store)
        except _NO_MESSAGE as error:
            raise CdrError(f"bytes that are no {self._name}") from error
        return message

    def _rebuilt(self, value: Any) -> Any:
        """Turn one of ROS's messages, or a field of one, into what rosbags encodes."""
        if hasattr(value, "get_fields_and_field_types"):
            fields = value.get_fields_and_field_types()
            kind = self._store.types[type_name(type(value))]
            return kind(**{name: self._rebuilt(getattr(value, name)) for name in fields})
        if isinstance(value, list):
            return [self._rebuilt(element) for element in value]
        if isinstance(value, bytes):  # an octet
            return int.from_bytes(value, "little", signed=True)
        return np.asarray(value) if isinstance(value, array) else value


def _types(name: str, definition: str) -> dict[str, Any]:
    """Return a definition's types; of IDL it holds one text for each, below a heading."""
    if not definition.startswith(_IDL):
        return get_types_from_msg(definition, name)
    types: dict[str, Any] = {}
    for part in definition.split(f"{SEPARATOR}\n")[1:]:
        types |= get_types_from_idl(part.partition("\n")[2])
    return types


def type_name(kind: Any) -> str:
    """Return the name of a message class, like ``sensor_msgs/msg/JointState``."""
    return f"{kind.__module__.partition('.')[0]}/msg/{kind.__name__}"


@cache
def cdr_type(name: str, definition: str = "") -> CdrType:
    """Return a type by its installed definition or, where there is none, by the one that a bag holds.

    Raises:
        ValueError: there is neither.
    """
    try:
        definition = message_definition(name)
    except FileNotFoundError as error:
        if not definition:
            raise ValueError(f"{name} is not installed here") from error
    return CdrType(name, definition)


def to_cdr(message: Any) -> bytes:
    """Return the bytes of one of ROS's messages.

    Raises:
        ValueError: its type has no definition that can be used.
    """
    return cdr_type(type_name(type(message))).encode(message)
