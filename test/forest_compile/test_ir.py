"""What is known of numbers while a function is written, and how the module's text has them."""

import re

import pytest

from forest_compile.ir.function import Function
from forest_compile.ir.module import Module
from forest_compile.ir.values import (
    BOOLEAN,
    DOUBLE,
    INTEGER,
    POINTER,
    NotTranslatedError,
    Scalar,
    known,
    member,
    number,
    same_structure,
)

LARGEST = 9007199254740991  # 2**53 - 1


@pytest.fixture
def into():
    return Function(Module({}))


def test_a_bound_is_of_the_size_whatever_the_sign(into):
    assert [into.bound(number(value)) for value in (-3, 3, 0, True)] == [3, 3, 0, 1]
    assert into.bound(Scalar(BOOLEAN, "%b")) == 1
    assert into.bound(Scalar(INTEGER, "%n")) == LARGEST
    one = into.bounded(Scalar(INTEGER, "%one"), number(-7), number(2), most=5)
    assert into.bound(one) == 7
    assert into.bound(into.bounded(Scalar(INTEGER, "%two"), number(-7), most=9)) == 9
    chosen = into.select(Scalar(BOOLEAN, "%b"), one, number(-8))
    assert into.bound(chosen) == 8
    assert into.bound(into.converted(Scalar(BOOLEAN, "%b"), INTEGER)) == 1


def test_a_constant_is_known_and_a_register_is_not():
    assert [known(number(value)) for value in (True, False, -12, 0)] == [1, 0, -12, 0]
    assert [known(Scalar(kind, "%v1")) for kind in (BOOLEAN, INTEGER, DOUBLE)] == [None] * 3
    assert known(number(2.0)) is None
    assert known(number(LARGEST)) == LARGEST
    for beyond in (LARGEST + 1, -LARGEST - 1):
        with pytest.raises(NotTranslatedError, match="beyond the largest whole number"):
            number(beyond)


def test_a_tuple_has_as_many_items_as_it_has_from_either_end(into):
    value = into.loaded((None, (DOUBLE, DOUBLE)), "%row", 3)
    assert member(value, -2) == member(value, 0)
    assert member(value, -1) == member(value, 1) == value.items[1]
    for index in (2, -3):
        with pytest.raises(NotTranslatedError, match=f"no item {index} in a tuple of 2"):
            member(value, index)
    assert sum("i64 3" in line or "i64 4" in line for line in into._bodies[into.block]) == 2


def test_structures_are_the_same_if_types_lengths_and_what_is_within_are():
    pair, row = (None, (DOUBLE, INTEGER)), (None, (POINTER, INTEGER))
    assert same_structure(pair, (None, (BOOLEAN, DOUBLE)))
    for other in (
        (None, (DOUBLE,)),
        (tuple, (DOUBLE, INTEGER)),
        row,
        DOUBLE,
        POINTER,
        (None, (pair, DOUBLE)),
    ):
        assert not same_structure(pair, other)
        assert not same_structure(other, pair)
    assert same_structure(POINTER, POINTER)
    assert not same_structure(POINTER, DOUBLE)


def test_the_text_of_a_fault_is_told_byte_by_byte_and_once():
    module, text = Module({"pow": 2, "sin": 1}), 'law ("a\\b", line 1):\n 2³ ~\x7f'
    assert module.fault(text) == module.fault(text) == "@fault.0"
    assert module.fault("another") == "@fault.1"
    lines = list(module.text())
    assert lines[:2] == ["declare double @pow(double, double) #2", "declare double @sin(double) #0"]
    size, told = re.fullmatch(
        r'@fault\.0 = private unnamed_addr constant \[(\d+) x i8\] c"(.*)"', lines[2]
    ).groups()
    assert re.fullmatch(r"(?:[ !#-\[\]-~]|\\[0-9a-f]{2})*", told)
    plain = re.sub(r"\\([0-9a-f]{2})", lambda code: chr(int(code[1], 16)), told).encode("latin-1")
    assert plain == text.encode() + b"\0"
    assert int(size) == len(plain)
