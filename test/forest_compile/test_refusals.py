"""What looks like the subset means what it means in Python, or is refused with its place, or is a fault."""

# ruff: noqa: A001, B007, B012, C409, PIE804, PLE0643, RET503, RUF015, SIM107 - wrong laws are the point.

import functools
import inspect
import math
import re
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_compile import machine_code
from forest_compile.entry import Entry
from forest_compile.frontend import translate
from forest_compile.ir.values import NotTranslatedError


class P(NamedTuple):
    x: float = 1.5
    y: float = -0.5
    n: int = 2
    on: bool = True


class Q(NamedTuple):
    x: float
    y: float


k, TWICE, NOTHING, WORDS, HUGE, LISTED = 5, (0.5, 1.5), None, "words", 2**53, [1.0]


class Named(IntEnum):
    ONE = 1


class Plain(tuple):
    """A tuple of no names."""

    __slots__ = ()


class Wider(Q):
    """A NamedTuple's heir, whose constructor may be another."""

    __slots__ = ()


def kernel_of(law, noinline=()):
    """A law of a `P` that gives one number, as machine code."""
    text = "def kernel(given, result):\n    result[0] = law(p)"
    entry = Entry(text, {"law": law}, "pp", {"p": ("given", P())}, noinline)
    kernel = machine_code.load(machine_code.optimised(translate.llvm_ir(entry)), "pp")

    def run(p):
        given, result = np.array(p, dtype=float), np.empty(1)
        kernel(given.ctypes.data, result.ctypes.data)
        return result[0]

    return run


def after_its_loop(p):
    i = 7
    for i in range(p.n):
        pass_by = i
        if pass_by > 3:
            break
    return i


def for_else(p):
    for i in range(4):
        if i == p.n:
            found = 1
            break
    else:
        found = 2
    return found


def while_else(p):
    i = 0
    while i < 3:
        i += 1
        if i == p.n:
            break
    else:
        i = 9
    return i


def either(p):
    return (p.x and p.y) - (p.y or 3.5) + 10.0 * ((p.n or 4) + (p.n and 8))


def from_the_end(p):
    return (0.5, 1.5, 2.5)[p.n % 3 - 3] + (1, 2, 3)[p.n % 2 - 2]


def backwards(p):
    total = 0
    for i in range(3, -3, 2 * p.n - 5 if p.n < 3 else -2):
        total = 3 * total + i
    return total


def signs(p):
    zeros = (
        math.copysign(1.0, p.x % -1.5),
        math.copysign(2.0, -(p.x > 9.0)),
        math.copysign(4.0, -abs(p.n - p.n)),
    )
    return zeros[0] + zeros[1] + zeros[2] + math.copysign(8.0, -3.0 % 1.5) + math.copysign(16.0, 0 * -p.n)


def roots(p):
    return (abs(p.x) + 0.3) ** 0.5 + abs(p.y) ** 2 + p.x**3


def once(p, counted=k):
    return float(0.0 < p.x <= counted != p.n) + float(0 < p.n < 3 and (1, 2, 3)[p.n] > 2)


def unequal(p):
    return float((p.x, p.y) == (p.x, p.y, 0.0)) + 2.0 * float((p.x, 1) != (p.x, True))


def of_its_own(x, more=0.25):
    return x + more


of_its_own.__wrapped__ = lambda x, more=0.5: x


def by_its_own_signature(p):
    return of_its_own(p.x)


def of_truths(p):
    return p.on + p.on - (not p.on) * 3 + abs(-p.on) + max(p.on, p.n) + int(p.on) % -2


RIGHT = [
    after_its_loop,
    for_else,
    while_else,
    either,
    from_the_end,
    backwards,
    signs,
    roots,
    once,
    unequal,
    by_its_own_signature,
    of_truths,
]


@pytest.mark.parametrize("law", RIGHT, ids=lambda law: law.__name__)
@pytest.mark.parametrize("noinline", [False, True], ids=["inlined", "called"])
def test_it_means_what_python_means(law, noinline):
    run, rng = kernel_of(law, (law,) if noinline else ()), np.random.default_rng(3)
    points = [
        P(*xy, n, on)
        for n in range(-4, 7)
        for on in (False, True)
        for xy in rng.normal(0, 2, (60, 2)).tolist()
    ]
    points += [P(x, y) for x in (0.0, -0.0, 3.0, -3.0, 1.5) for y in (0.0, -0.0, 2.0)]
    for p in points:
        expected = float(law(p))
        assert run(p) == expected, p
        assert math.copysign(1.0, run(p)) == math.copysign(1.0, expected), p


def left_over(p):
    for k in range(p.n):
        last = k
    return k + last


def twice(p):
    return p.x


FIRST = twice


def twice(p):
    return p.y


def test_of_a_function_defined_twice_each_is_itself():
    assert [kernel_of(law)(P()) for law in (FIRST, twice)] == [1.5, -0.5]


def negated(function):
    return lambda p: -function(p)


@functools.cache
def remembered(p):
    return p.x


@negated
def replaced(p):
    return p.x


def unchanged(function):
    return function


@unchanged
def wrapped(p):
    return -p.x


def remembers(p):
    return remembered(p)


def of_another_function(p):
    return replaced(p)


def decorated_within(p):
    return wrapped(p)


def bound_to_a_global(p):
    if p.on:
        k = p.n
    return k


def two_kinds(p):
    step = 0 if p.on else p.x
    return -step


def greatest_of_two_kinds(p):
    return max(0, p.x)


def of_two_sorts(p):
    pair = Q(p.x, p.y) if p.on else (p.x, p.y)
    return pair[0]


def of_two_lengths(p):
    pair = (p.x, p.y) if p.on else (p.x, p.y, p.x)
    return pair[0]


def calls_itself(p):
    return calls_itself(p)


def round_about(p):
    return round_and_back(p)


def round_and_back(p):
    return round_about(p)


def without_return(p):
    if p.on:
        return p.x


def whole_power(p):
    return p.n**2


def too_many(p):
    a, b = (p.x, p.y, p.x)
    return a + b


def beyond(p):
    return (p.x, p.y)[2] + p[9]


def too_large(p):
    return p.n + HUGE


def grown_too_large(p):
    return 94906266 * 94906267


def wrong_arguments(p):
    return once(p, 1, 2)


def wrong_field(p):
    return Q(p.x, z=p.y).x


def missing_field(p):
    return Q(p.x).x


def unknown_keyword(p):
    return once(p, other=1)


def given_twice(p):
    return once(p, p=p)


def field_given_twice(p):
    return Q(p.x, x=p.y).x


def of_place_alone(x, /):
    return x


def named_against_its_place(p):
    return of_place_alone(x=p.x)


def of_keyword_alone(x, *, scale):
    return scale * x


def without_its_keyword(p):
    return of_keyword_alone(p.x)


def placed_against_its_keyword(p):
    return of_keyword_alone(p.x, p.y)


def limited(x, most=None):
    return min(x, most)


def without_the_limit(p):
    return limited(p.x)


def spread(p):
    return once(*(p, 1))


def spread_fields(p):
    return Q(*(p.x, p.y)).x


def spread_names(p):
    return once(p, **{"counted": 1})


def spread_named_fields(p):
    return Q(**{"x": p.x, "y": p.y}).x


def replaced_by_spread_names(p):
    return p._replace(**{"x": p.y}).x


def replaced_unknown(p):
    return p._replace(x=p.y, z=p.x).x


def replaced_by_place(p):
    return p._replace(p.y).x


def replaced_in_a_plain_tuple(p):
    return (p.x, p.y)._replace(x=p.y)[0]


def of_any_names(**numbers):
    return numbers["x"]


def calls_any_names(p):
    return of_any_names(x=p.x)


def named_of_a_builtin(p):
    return max(p.x, p.y, default=0.0)


def of_any_number(*numbers):
    return numbers[0]


def calls_any_number(p):
    return of_any_number(p.x)


def shadowed_range(p):
    range = p.n
    for i in range(3):
        p = i
    return p


def shadowed_max(p):
    max = p.x
    return max(p.x, 1.0)


def of_a_real_range(p):
    total = 0
    for i in range(2.5):
        total += i
    return total


def without_stride(p):
    for i in range(0, 3, 0):
        p = i
    return p


def within(p):
    return p.x in (1.0, 2.0)


def same(p):
    return p.x is p.y


def absent(p):
    return math.nonsense + p.x


def misspelt(p):
    return p.x + undefined  # noqa: F821


def nothing(p):
    return NOTHING


def a_word(p):
    return WORDS


def of_a_list(p):
    return LISTED[0] + p.x


def item_changed(p):
    pair = (p.x, p.y)
    pair[0] += 1.0
    return pair[0]


def field_changed(p):
    p.x = 1.0
    return p.x


def made_a_tuple(p):
    return tuple((p.x, p.y))[0]


def tuples_in_order(p):
    return (p.x, p.y) < (p.y, p.x)


def a_number_and_a_tuple(p):
    return p.x == (p.x, p.y)


def a_tuple_and_a_number(p):
    return (p.x, p.y) != p.x


def greatest_of_a_list(p):
    return max([p.x + i for i in range(2)])


def gone_through_a_function(p):
    return tuple([p.x + i for i in once(p)])[0]


def of_no_names(p):
    return Plain((p.x, p.y))[0]


def of_an_heir(p):
    return Wider(p.x, p.y).x


def rounded(p):
    return round(p.x)


def of_one(p):
    return max(p.x)


def nested(p):
    def inner(x):
        return x

    return inner(p.x)


def of_a_lambda(p):
    return HALF(p.x)


HALF = lambda x: 0.5 * x  # noqa: E731


def real_index(p):
    return (1.0, 2.0)[p.x]


def matrix(p):
    return p.x @ p.y


def floored(p):
    return p.x // p.y


def inverted(p):
    return ~p.n


def formatted(p):
    return f"{p.x}"


def tried(p):
    try:
        return p.x
    finally:
        return p.y


def a_global(p):
    global k
    k = p.n
    return k


def of_an_enum(p):
    return Named(p.n)


def of_a_tuple_as_truth(p):
    return p.x if (p.x, p.y) else p.y


def another_kind_after_a_loop(p):
    total = 0
    for i in range(p.n):
        total = total + 0.5 * i
    return total


def very_deep(p):
    return p.x


class Law:
    def method(self):
        return self.x


REFUSED = {
    left_over: "'k' has no value of one kind on every way here",
    remembers: r"'remembered\(p\)' is not translated",
    of_another_function: "only functions that a module defines by themselves",
    decorated_within: "a decorated function is not translated",
    bound_to_a_global: "'k' has no value",
    two_kinds: "a double on one way, a whole number on another",
    greatest_of_two_kinds: "a double on one way",
    of_two_sorts: "tuples of different types or lengths",
    of_two_lengths: "tuples of different types or lengths",
    calls_itself: "'calls_itself' calls itself",
    round_about: "'round_about' calls itself",
    without_return: "returns nothing",
    whole_power: "Pow of whole numbers is not translated",
    too_many: "is given a tuple of 3",
    beyond: "there is no item 2 in a tuple of 2",
    too_large: "9007199254740992 is beyond the largest whole number",
    grown_too_large: "is beyond the largest whole number",
    wrong_arguments: "too many positional arguments",
    wrong_field: "missing a required argument: 'y'",
    missing_field: "missing a required argument: 'y'",
    unknown_keyword: "unexpected keyword argument 'other'",
    given_twice: r"'once\(p, p=p\)': multiple values for argument 'p'",
    field_given_twice: "multiple values for argument 'x'",
    named_against_its_place: "of_place_alone.*positional",
    without_its_keyword: "missing a required.* argument: 'scale'",
    placed_against_its_keyword: "too many positional arguments",
    without_the_limit: r"'limited\(p.x\)': the default of 'most': None is no number",
    spread: "Starred is not translated",
    spread_fields: "Starred is not translated",
    spread_names: r"once\(p, \*\*.*\*\* is not translated",
    spread_named_fields: r"\*\* is not translated",
    replaced_by_spread_names: r"\*\* is not translated",
    replaced_unknown: "there is no field 'z'",
    replaced_by_place: r"'p._replace\(p.y\)' is not translated",
    replaced_in_a_plain_tuple: "is not translated",
    calls_any_names: "any number of arguments is not translated",
    named_of_a_builtin: "'max.*' is not translated",
    calls_any_number: "any number of arguments is not translated",
    shadowed_range: "only ranges are gone through",
    shadowed_max: "'max' has no meaning outside the function",
    of_a_real_range: "a double where Python takes a whole number",
    without_stride: "a range's stride is zero",
    within: "In is not translated",
    same: "Is is not translated",
    absent: "'math.nonsense' has no meaning",
    misspelt: "'undefined' has no meaning",
    nothing: "None is no number",
    a_word: "'words' is no number",
    of_a_list: r"\[1.0\] is no number",
    item_changed: "only rows take numbers",
    field_changed: "'p.x' is not assigned to",
    made_a_tuple: "is not translated",
    tuples_in_order: "tuples are compared with tuples, for equality alone",
    a_number_and_a_tuple: "tuples are compared with tuples, for equality alone",
    a_tuple_and_a_number: "tuples are compared with tuples, for equality alone",
    greatest_of_a_list: "ListComp is not translated",
    gone_through_a_function: "ListComp is not translated",
    of_no_names: r"'Plain\(\(p.x, p.y\)\)' is not translated",
    of_an_heir: r"'Wider\(p.x, p.y\)' is not translated",
    rounded: r"'round\(p.x\)' is not translated",
    of_one: "not with 1 numbers",
    nested: "FunctionDef is not translated",
    of_a_lambda: "only functions that a module defines by themselves",
    real_index: "a double where Python takes a whole number",
    matrix: "MatMult is not translated",
    floored: "FloorDiv is not translated",
    inverted: "is not translated",
    formatted: "JoinedStr is not translated",
    tried: "Try is not translated",
    a_global: "Global is not translated",
    of_an_enum: "is not translated",
    of_a_tuple_as_truth: "is no number",
    another_kind_after_a_loop: "a double on one way, a whole number on another",
    Law.method: "only functions that a module defines by themselves",
}


@pytest.mark.parametrize("law", REFUSED, ids=lambda law: law.__name__)
def test_it_is_refused_with_function_file_and_line(law):
    with pytest.raises(NotTranslatedError, match=REFUSED[law]) as caught:
        kernel_of(law)
    place = re.match(r"\S+test_refusals\.(\S+) \(test_refusals\.py, line (\d+)\): ", str(caught.value))
    inner = (
        function
        for function in (round_and_back, wrapped, HALF, replaced)
        if function.__qualname__ == place[1]
    )
    named = next(inner, law)
    lines, first = inspect.getsourcelines(named)
    assert place[1] == named.__qualname__
    assert first <= int(place[2]) < first + len(lines)


def test_an_expression_too_deep_for_the_translator_is_refused_too(tmp_path):
    text = f"def deep(p):\n    return {'-' * 700}p.x\n"
    (tmp_path / "deep.py").write_text(text, encoding="utf-8")
    names = {}
    exec(compile(text, str(tmp_path / "deep.py"), "exec"), names)
    with pytest.raises(
        NotTranslatedError, match=r"deep \(deep.py, line 2\): not translated, for RecursionError"
    ):
        kernel_of(names["deep"])


def test_a_function_without_a_file_is_refused():
    names = {"__name__": "typed"}
    exec("def typed(p):\n    return p.x", names)
    with pytest.raises(NotTranslatedError, match=r"typed.typed \(<string>, line 1\): its source is no file"):
        kernel_of(names["typed"])


def product(p):
    return p.n * 4194304 * 4194304 * 256


def square(p):
    return p.n * p.n


def summed(p):
    total = p.n
    for i in range(60):
        total = total + total
    return total


def doubled(p):
    two = p.n + p.n
    eight = two + two + two + two
    sixty_four = eight + eight + eight + eight + eight + eight + eight + eight
    many = sixty_four + sixty_four + sixty_four + sixty_four + sixty_four + sixty_four + sixty_four
    return many + many


def halved(p):
    there_and_back = (p.n + 9007199254740991) - 9007199254740991
    return there_and_back + (p.n + 9007199254740990) / 2


def cut(p):
    return int(p.x)


def floor(p):
    return math.floor(p.x)


def item(p):
    return (1.0, 2.0, 3.0)[p.n]


def remainder(p):
    return 7 % p.n


def strided(p):
    total = 0
    for i in range(0, 9, p.n):
        total += i
    return total


def by_name(x, *, y=0.5):
    return x + y


def first_named(p):
    return by_name(y=float(int(p.x)), x=(1.0, 2.0, 3.0)[p.n])


def last_named(p):
    return by_name(x=(1.0, 2.0, 3.0)[p.n], y=float(int(p.x)))


def first_field(p):
    return Q(y=float(int(p.x)), x=(1.0, 2.0, 3.0)[p.n]).x


def last_field(p):
    return Q(x=(1.0, 2.0, 3.0)[p.n], y=float(int(p.x))).x


def first_replaced(p):
    return p._replace(y=float(int(p.x)), x=(1.0, 2.0, 3.0)[p.n]).x


def last_replaced(p):
    return p._replace(x=(1.0, 2.0, 3.0)[p.n], y=float(int(p.x))).x


BOTH = P(math.nan, n=3)  # int() and the index both fail: Python tells of what is written first
FAULTS = [
    (first_named, BOTH, "a whole number beyond"),
    (last_named, BOTH, "an index beyond"),
    (first_field, BOTH, "a whole number beyond"),
    (last_field, BOTH, "an index beyond"),
    (first_replaced, BOTH, "a whole number beyond"),
    (last_replaced, BOTH, "an index beyond"),
    (product, P(n=2), "a whole number beyond"),
    (square, P(n=2**32), "a whole number beyond"),
    (square, P(n=-(2**31) * 3), "a whole number beyond"),
    (summed, P(n=1), "a whole number beyond"),
    (doubled, P(n=2**44), "a whole number beyond"),
    (halved, P(n=2), "a whole number beyond"),
    (cut, P(math.nan), "a whole number beyond 2.*or of no number"),
    (cut, P(-1e16), "a whole number beyond"),
    (floor, P(math.inf), "a whole number beyond"),
    (item, P(n=3), "an index beyond a tuple of 3"),
    (item, P(n=-4), "an index beyond a tuple of 3"),
    (remainder, P(n=0), "a remainder by zero"),
    (strided, P(n=0), "stride is zero"),
]


@pytest.mark.parametrize("noinline", [False, True], ids=["inlined", "called"])
@pytest.mark.parametrize(("law", "p", "fault"), FAULTS)
def test_what_does_not_fit_is_an_error_that_tells_its_place(law, p, fault, noinline):
    run, line = kernel_of(law, (law,) if noinline else ()), law.__code__.co_firstlineno
    harmless, place = P(n=0 if law is summed else 1), rf"{law.__name__} \(test_refusals.py, line \d+\): "
    with pytest.raises(ArithmeticError, match=place + f".*{fault}") as caught:
        run(p)
    assert line < int(re.search(r"line (\d+)", str(caught.value))[1]) < line + 6
    assert run(harmless) == law(harmless)


# fmt: off
def over_lines(p):
    return (
        7
        % p.n
        + p.x
    )
# fmt: on


def test_a_fault_tells_the_line_in_which_its_operation_begins():
    line = over_lines.__code__.co_firstlineno + 2
    with pytest.raises(ArithmeticError, match=rf"over_lines \(test_refusals.py, line {line}\): a remainder"):
        kernel_of(over_lines)(P(n=0))


def in_a_pair(p):
    return p.x, p.n + p.n


def of_a_pair(p):
    return in_a_pair(p)[1]


def doubled_in_a_pair(p):
    pair = (0.0, p.n)
    for i in range(64):  # beyond a register's last bit nothing would be left
        pair = (p.x, pair[1] + pair[1])
    return pair[1]


@pytest.mark.parametrize("noinline", [(), (in_a_pair,)], ids=["inlined", "called"])
@pytest.mark.parametrize(
    ("law", "n", "harmless"), [(of_a_pair, 2**53 - 1, 2**52 - 1), (doubled_in_a_pair, 1, 0)]
)
def test_so_is_a_whole_number_that_is_too_large_within_a_tuple(law, n, harmless, noinline):
    run = kernel_of(law, noinline)
    with pytest.raises(ArithmeticError, match="a whole number beyond"):
        run(P(n=n))
    assert run(P(n=harmless)) == law(P(n=harmless))


def constants(p):
    return 7 % 0 if p.on else 7 % -1 + 1


def test_a_remainder_of_constants_is_a_fault_where_it_is_reached_alone():
    run = kernel_of(constants)
    assert run(P(on=False)) == 1.0
    with pytest.raises(ArithmeticError, match="a remainder by zero"):
        run(P(on=True))


def turned(pair):
    return pair[1], pair[0]


def in_turn(p):
    first = turned((p.x, p.y))
    second = turned((p.x + 10.0, p.y + 10.0))
    third = turned(first)
    return 1e4 * third[0] + 1e2 * first[p.n % 2] + second[p.n % 2]


@pytest.mark.parametrize("p", [P(1.0, 2.0, 0), P(3.0, 4.0, 1)])
def test_what_a_called_function_gave_stays_while_it_is_called_again(p):
    assert kernel_of(in_turn, (turned,))(p) == in_turn(p)


def test_an_entry_has_a_letter_for_each_of_its_arguments():
    for letters in ("p", "ppd"):
        with pytest.raises(ValueError, match="zip"):
            translate.llvm_ir(Entry("def kernel(given, result):\n    result[0] = given[0]", {}, letters, {}))


@pytest.mark.parametrize("p", [P(n=2.5), P(n=2.0**53), P(n=math.nan), P(on=0.5), P(on=2.0), P(on=math.nan)])
def test_what_lies_in_a_row_for_a_whole_number_must_be_one(p):
    with pytest.raises(ArithmeticError, match=r"kernel: p.* is no (whole number|truth)"):
        kernel_of(cut)(p)


def test_a_negative_index_of_a_row_is_an_error():
    def read(index, at):
        text = f"def kernel(given, result, at):\n    result[0] = given[{index}]"
        entry = Entry(text, {}, "ppi", {})
        numbers = np.array([2.5, 0.0, 7.5])
        kernel = machine_code.load(machine_code.optimised(translate.llvm_ir(entry)), "ppi")
        kernel(numbers.ctypes.data, numbers.ctypes.data + 8, at)
        return numbers[1]

    assert read("at", 2) == 7.5
    with pytest.raises(NotTranslatedError, match=r"forest_kernel \(forest_kernel, line 2\): index -1"):
        read("-1", 0)
    with pytest.raises(ArithmeticError, match=r"forest_kernel \(forest_kernel, line 2\): a negative index"):
        read("at", -1)
