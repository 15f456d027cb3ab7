"""Claims that what is translated means what Python means, to the last bit, and that all else is refused."""

import math
import re
from enum import IntEnum
from typing import NamedTuple

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_compile import flat_layout, machine_code
from forest_compile.entry import Entry, RuntimeNumber
from forest_compile.frontend import translate
from forest_compile.ir.values import NotTranslatedError

LIMITS = (-1.0, 2.0)
POWERS = (1.0, 0.5, 0.25, 0.125)


class Point(NamedTuple):
    x: float
    y: float
    count: int


class Side(IntEnum):
    LEFT = 4


class Marked(NamedTuple):
    point: Point
    mark: bool = True
    side: int = Side.LEFT


def translated(function, example, noinline=()):
    """Return a function of a flat tuple as machine code; it returns a flat row."""
    result = function(example)
    paths = [path for path, _ in flat_layout.leaves(result, "result")]
    lines = ["def kernel(given, results):", "    result = function(value)"]
    lines += [f"    results[{i}] = {path}" for i, path in enumerate(paths)]
    tuples = {"value": ("given", example)}
    entry = Entry("\n".join(lines), {"function": function}, "pp", tuples, noinline)
    kernel = machine_code.load(machine_code.optimised(translate.llvm_ir(entry)), "pp")

    def run(value):
        given, results = np.array(flat_layout.packer(example)(value), dtype=float), np.empty(len(paths))
        kernel(given.ctypes.data, results.ctypes.data)
        return results

    return run


def assert_translated(function, values, noinline=()):
    run = translated(function, values[0], noinline)
    for value in values:
        result = function(value)
        np.testing.assert_array_equal(run(value), [number for _, number in flat_layout.leaves(result, "")])


def points(count=30):
    draws = np.random.default_rng(5).normal(0.0, 2.0, (count, 2)).tolist()
    return [Point(x, y, i % 5 - 1) for i, (x, y) in enumerate(draws)]


def arithmetic(p):
    total = p.x + 2 * p.y - p.count
    total -= p.x / (1 + p.y**2)
    return total, -p.x, -p.count, 3 - p.count * 2, abs(p.x), math.copysign(math.sqrt(abs(p.y)), p.x)


def functions(p):
    clipped = min(LIMITS[1], max(LIMITS[0], p.x))
    return (
        clipped,
        max(p.x, p.y, float(p.count)),
        min(p.count, 1),
        math.sin(p.x),
        math.cos(p.x),
        math.exp(p.y),
    )


def choices(p):
    if p.x < 0.0 and not p.y < 0.0:
        side, name = -1.0, 1
    elif p.x < p.y < 1.0 or p.count == 2:
        return 7.0, p.count, Point(p.y, p.x, 0)
    else:
        side, name = (0.5, 2) if p.count else (p.y, 3)
    steep = p.y > 1.0 and p.x > 0.0
    return side, name + int(steep) + int(p.x >= 0.0), p


def loops(p):
    total, last = 0.0, 0
    for k in range(p.count + 2):
        if k == 3:
            break
        total += p.x * k
        last = k
    ratio = 0.0
    for k in range(len_of_powers() - 1, -1, -1):
        ratio = ratio * p.y + POWERS[-1] * k
    k = 0
    while k < 10 and total > -4.0:
        total -= 1.0
        if total < p.y:
            return total, k, ratio
        k += 1
    return total, last, ratio


def len_of_powers():
    return 4


def search(row):
    k = 1
    while row.knots[k] < row.at:
        k += 1
    return row.knots[k - 1], k


class Table(NamedTuple):
    at: float
    knots: tuple[float, float, float, float]


def tuples(p):
    (a, b), c = swapped((p.x, p.y)), Point(count=p.count, x=p.y, y=p.x)
    same, other = (a, (b, 1)) == (p.y, (p.x, 1)), swapped((a, b)) != (p.x, p.y + 1.0)
    return c, int(same), int(other), (a, b)[1], c[0]


def swapped(pair):
    return pair[1], pair[0]


def with_defaults(p, scale=2.0, shift=0):
    return scale * p.x + shift


def changed(p):
    marked = Marked(p._replace(x=p.y), p.x < 0.0)
    other = Marked(p)._replace(side=Side.LEFT + 1) if marked.mark else marked
    return marked, other, with_defaults(p), with_defaults(p, shift=1), int(other.side == Side.LEFT)


def powers(p):
    size = abs(p.x) + 0.1
    return (
        size**3,
        size**1.5,
        size**2,
        size**0.5,
        size**p.y,
        2.0**p.x,
        p.x % 1.0,
        p.x % -0.7,
        p.count % 2,
        p.count % -3,
    )


def angles(p):
    known = int(math.isnan(p.x * math.inf - math.inf)), bool(p.count), math.floor(p.x), math.floor(3.0 * p.y)
    return math.acos(math.sin(p.x)), math.atan2(p.y, p.x), known


def listed_out(p):
    pair = (p.x, p.y)
    return (*tuple([pair[i] * i for i in range(2)]), p.count, *swapped(pair))


def gone_through(p):
    rows, total = ((p.x, 1.0), (p.y, 2.0), (0.5, p.x)), 0.0
    for i in range(3):
        if rows[i][0] < 0.0:
            continue
        total += rows[i][0] * rows[i][1]
    return total, rows[p.count % 3]


def not_numbers(p):
    nan = p.x * math.inf - p.x * math.inf
    return int(nan < 1.0), int(not nan >= 1.0), int(nan != nan), int(math.isfinite(nan)), max(1.0, nan)


def left_early(p):
    total, rounds = 0.0, 0
    for i in range(6):
        rounds = rounds + 1
        if i == p.count + 2:
            total = total + 100.0
            break
        if i == 1 or p.x > 1.0:
            total = total - p.y
            continue
        total = total + p.x
    else:
        total = total * 2.0
    while rounds > 0:
        rounds -= 2
        if rounds == 1:
            total += 0.5
            break
    else:
        total -= 0.25
    for k in range(5, p.count, -2):
        total = total * 0.5 + k
    for k in range(p.count, 3):
        total += k
    return total, rounds


def carried(p):
    pair, point = (p.x, (p.y, p.count)), p
    for i in range(4):
        pair = (pair[1][0], (pair[0] + 1.0, i))
        point = point._replace(x=point.y, y=0.5 * point.x)
    return pair, point


def whole_numbers(p):
    n, on = p.count, p.x > 0.0
    products = (n - 2) * (n + 2), n * 7 - 3, n * on, -on, on + on, n * -n
    rests = n % 5, n % -5, -7 % (n * n + 1), (n - 9) % 4
    return (
        products,
        rests,
        (min(n, 2), max(n, 0, -1)),
        (n == 2) != on,
        not n,
        abs(n - 1),
        (n, on) == (1, True),
    )


LANGUAGE = [arithmetic, functions, choices, loops, tuples, not_numbers]
LANGUAGE += [changed, powers, angles, listed_out, gone_through, left_early, carried, whole_numbers]


@pytest.mark.parametrize("law", LANGUAGE)
def test_machine_code_is_python_to_the_last_bit(law):
    assert_translated(law, points())


def test_a_stored_row_takes_a_variable_index():
    assert_translated(search, [Table(at, (0.0, 0.5, 1.5, 9.0)) for at in (0.2, 0.5, 1.4, 8.0)])


def third_of_many(many):
    total = 0.0
    for i in range(many.number):
        total += many.points[i].x * many.points[i].count
    return total, many.points[many.number - 1]


class Many(NamedTuple):
    number: int
    points: tuple[Point, ...]


def test_so_does_a_stored_row_of_tuples():
    assert_translated(third_of_many, [Many(n, tuple(points(3))) for n in (1, 2, 3)])


def test_a_function_that_is_not_inlined_is_the_same():
    assert_translated(tuples, points(), (swapped, len_of_powers))
    assert_translated(nested, points(), (choices, loops))


def by_way(p):
    if p.count > 0:
        return p.x
    return p.y


def test_a_called_function_loads_only_what_its_way_needs():
    """Loaded at its beginning, the numbers of all ways would wait on the stack."""
    text = "def kernel(given, row):\n    row[0] = by_way(p)"
    entry = Entry(text, {"by_way": by_way}, "pp", {"p": ("given", points(1)[0])}, (by_way,))
    called = translate.llvm_ir(entry).partition("define internal ")[2].partition("\n}")[0]
    loads = [block.count("= load ") for block in re.split(r"\nb\d+:\n", called)]
    assert sum(loads) == 3
    assert max(loads) == 1


def filled(row, p):
    row[1] = p.x + p.y
    row[2] = row[1] * p.count
    return row[1] - p.x


@pytest.mark.parametrize("noinline", [(), (filled,)], ids=["inlined", "called"])
def test_a_function_may_write_to_a_row(noinline):
    text = "def kernel(given, row):\n    row[0] = filled(row, p)"
    entry = Entry(text, {"filled": filled}, "pp", {"p": ("given", points(1)[0])}, noinline)
    kernel = machine_code.load(machine_code.optimised(translate.llvm_ir(entry)), "pp")
    for p in points():
        expected, row, given = [0.0, 0.0, 0.0], np.zeros(3), np.array(p, dtype=float)
        expected[0] = filled(expected, p)
        kernel(given.ctypes.data, row.ctypes.data)
        assert row.tolist() == expected


def nested(p):
    return choices(p), loops(Point(p.y, p.x, 1)), loops(p)


def mixed(p):
    return (p.x, (p.x, p.y))[p.count]


def listed(p):
    return [p.x]


def unknown(p):
    return math.erf(p.x)


def misspelt(p):
    return p.z


@pytest.mark.parametrize(
    ("law", "complaint"),
    [
        (mixed, "only items alike"),
        (listed, r"'\[p.x\]': List is not translated"),
        (unknown, r"unknown \(test_translate.py, line \d+\): 'math.erf\(p.x\)' is not translated"),
        (misspelt, "'p.z': there is no such field"),
    ],
)
def test_what_is_outside_the_subset_is_refused_by_name(law, complaint):
    text = "def kernel(given):\n    result = law(value)"
    entry = Entry(text, {"law": law}, "p", {"value": ("given", points(1)[0])})
    with pytest.raises(NotTranslatedError, match=complaint):
        translate.llvm_ir(entry)


def growing(p):
    total = 0
    for k in range(3):
        total += k * p.x
    return total


def test_a_loop_does_not_make_a_float_of_a_whole_number():
    with pytest.raises(NotTranslatedError, match="a double on one way, a whole number on another"):
        translated(growing, points(1)[0])


GIVEN = (RuntimeNumber(2.0, 1), (RuntimeNumber(3.0, 0), 4.0))


def by_what_is_given(x):
    return GIVEN[0] * x + GIVEN[1][0] + GIVEN[1][1]


def seldom_by_what_is_given(x):
    return by_what_is_given(x) + GIVEN[0]


@pytest.mark.parametrize("noinline", [(), (by_what_is_given,)])
def test_numbers_of_the_time_when_a_kernel_runs_are_read_whenever_it_does(noinline):
    """Inlined or not, and by one piece of code: a change of them needs no other."""
    text = "def kernel(x, runtime):\n    x[0] = seldom_by_what_is_given(x[0])"
    entry = Entry(text, {"seldom_by_what_is_given": seldom_by_what_is_given}, "pp", {}, noinline)
    kernel = machine_code.load(machine_code.optimised(translate.llvm_ir(entry)), "pp")
    for given in ([3.0, 2.0], [-1.0, 0.5]):
        x, row = np.array([7.0]), np.array(given)
        kernel(x.ctypes.data, row.ctypes.data)
        assert x[0] == given[1] * 7.0 + given[0] + 4.0 + given[1]


def test_numbers_of_the_time_when_a_kernel_runs_must_be_given_to_it():
    text = "def kernel(x):\n    x[0] = by_what_is_given(x[0])"
    entry = Entry(text, {"by_what_is_given": by_what_is_given}, "p", {})
    with pytest.raises(NotTranslatedError, match=r"line \d+\): .*its entry is given none"):
        translate.llvm_ir(entry)
