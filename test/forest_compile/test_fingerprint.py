"""Claims that a kernel's digest changes with all that decides the kernel, and with little else."""

import importlib
import itertools
import sys
from pathlib import Path

import pytest

pytest.importorskip("llvmlite")

from forest_compile import fingerprint
from forest_compile.entry import Entry, RuntimeNumber
from forest_compile.frontend import translate

KINDS = """
from enum import IntEnum
from typing import NamedTuple

class Side(IntEnum):
    LEFT = 1
    RIGHT = 2

class Oil(NamedTuple):
    density: float
    stiffness: float = 1.5

class Line(NamedTuple):
    oil: Oil
    lengths: tuple[float, ...]
    steps: int

class Result(NamedTuple):
    flow: float
    loss: float = 0.25
"""
DEEP = """
import math

LIMITS = (0.5, 2.0)
SCALE = 3.0
UNUSED = 7.0

def curve(x, slope=2.0):
    return slope * x + math.sin(x)

def limited(x):
    "Keep it within."
    return max(LIMITS[0], min(x, LIMITS[1]))

def unrelated(x):
    return SCALE * x
"""
TOP = """
from {kinds} import Line, Result, Side
import {deep} as deep
from {deep} import curve

def law(line):
    total = 0.0
    for i in range(line.steps):
        total += deep.limited(line.lengths[i]) if i != Side.RIGHT else curve(line.oil.density)
    return Result(total)
"""
ENTRY = "def kernel(given, results):\n    results[0] = law(line).flow"
numbers = itertools.count()


@pytest.fixture
def entry(tmp_path, monkeypatch):
    """Returns the entry of a law in three modules, with a piece of one replaced."""
    monkeypatch.syspath_prepend(tmp_path)
    made = []

    def make(before="", after="", values=lambda kinds: ((0.3, 0.7), 2)):
        made.append(names := {name: f"{name}_{next(numbers)}" for name in ("kinds", "deep", "top")})
        for name, text in (("kinds", KINDS), ("deep", DEEP), ("top", TOP.format(**names))):
            (tmp_path / f"{names[name]}.py").write_text(text.replace(before, after) if before else text)
        importlib.invalidate_caches()
        modules = {name: importlib.import_module(file) for name, file in names.items()}
        for name, module in modules.items():  # as if they had always had these names
            module.__name__ = name
            for value in vars(module).values():
                if getattr(value, "__module__", "") == names[name]:
                    value.__module__ = name
        kinds = modules["kinds"]
        lengths, steps = values(kinds)
        line = kinds.Line(kinds.Oil(1.0), lengths, steps)
        law = modules["top"].law
        return Entry(ENTRY, {"law": law}, "pp", {"line": ("given", line)}, (modules["deep"].limited,))

    yield make
    for names in made:
        for name in names.values():
            del sys.modules[name]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("stiffness: float = 1.5", "stiffness: float = 1.5\n    bulk: float = 2.0"),  # a field with a default
        ("stiffness: float = 1.5", "stiffness: float = 1.6"),
        ("loss: float = 0.25", "loss: float = 0.5"),
        ("steps: int", "count: int"),
        ("RIGHT = 2", "RIGHT = 0"),
        ("LIMITS = (0.5, 2.0)", "LIMITS = (0.5, 2.5)"),
        ("LIMITS = (0.5, 2.0)", "LIMITS = (0.5, 2)"),
        ("slope=2.0", "slope=2.5"),
        ("math.sin(x)", "math.cos(x)"),
        ("+ math.sin(", "- math.sin("),
        ("max(LIMITS[0]", "max(LIMITS[-2]"),
        ("total = 0.0", "total = -0.0"),
        ("Result(total)", "Result(total, 0.25)"),
        ("curve(line.oil.density)", "curve(line.oil.stiffness)"),
        ("import curve", "import limited as curve"),
        ("def curve", "# another line, of which a kernel may tell\ndef curve"),
        ("import math\n", "import math\n\ndef max(a, b):\n    return a\n"),  # another meaning of a name
    ],
)
def test_a_change_of_what_counts_is_another_digest(entry, before, after):
    assert fingerprint.digest(entry(before, after)) != fingerprint.digest(entry())


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("", ""),
        ("def unrelated(x):\n    return SCALE", "def unrelated(x):\n    return UNUSED"),
        ("SCALE = 3.0", "SCALE = 4.0"),
        (
            "    return slope * x + math.sin(x)",
            "    return slope * x + math.sin(x)  # a comment",
        ),
        ("Keep it within.", "Keep x within limits."),
        ("UNUSED = 7.0", "UNUSED = 8.0"),
    ],
)
def test_a_change_of_what_does_not_count_is_none(entry, before, after):
    assert fingerprint.digest(entry(before, after)) == fingerprint.digest(entry())


@pytest.mark.parametrize(
    "values", [((0.3, 0.7, 0.1), 2), ((0.3, 1), 2), (((0.3, 0.7),), 2), ((0.3, 0.7), 2.0)]
)
def test_another_flat_layout_is_another_digest(entry, values):
    assert fingerprint.digest(entry(values=lambda _: values)) != fingerprint.digest(entry())


def test_other_numbers_in_the_same_layout_are_no_other_digest(entry):
    assert fingerprint.digest(entry(values=lambda _: ((9.0, -1.0), 1))) == fingerprint.digest(entry())


def test_of_a_number_that_a_kernel_reads_as_it_runs_the_place_counts_alone(entry):
    digests = []
    for value, place in ((3.0, 0), (4.0, 0), (3.0, 1)):
        given = entry()
        given.names["law"].__globals__["deep"].LIMITS = RuntimeNumber(value, place), 2.0
        digests.append(fingerprint.digest(given))
    assert digests[0] == digests[1] != digests[2]
    assert digests[0] != fingerprint.digest(entry())


def test_another_default_of_a_keyword_is_another_digest(entry):
    some, others = (entry("slope=2.0", f"slope=2.0, *, phase={phase}") for phase in (0.0, 0.5))
    assert fingerprint.digest(some) != fingerprint.digest(others)


@pytest.mark.parametrize("name", ["__qualname__", "__module__"])
def test_a_law_of_another_name_or_file_is_another_digest(entry, name):
    """Faults tell of both."""
    renamed = entry()
    setattr(renamed.names["law"], name, "another")
    assert fingerprint.digest(renamed) != fingerprint.digest(entry())


def test_so_do_all_parts_of_an_entry(entry):
    whole = entry()
    parts = [
        {"text": whole.text + "\n"},
        {"arguments": "pd"},
        {"names": {**whole.names, "more": 1.0}},
        {"tuples": {"line": ("results", whole.tuples["line"][1])}},
        {"tuples": {"pipe": whole.tuples["line"]}},
        {"tuples": {}},
        {"noinline": ()},
    ]
    digests = {fingerprint.digest(whole._replace(**part)) for part in parts}
    assert len(digests | {fingerprint.digest(whole)}) == len(parts) + 1


def test_a_law_whose_file_was_changed_since_it_was_imported_is_refused(entry):
    """Or the new source's kernel would be kept under the old one's digest."""
    whole = entry()
    assert "@forest_kernel(" in translate.llvm_ir(whole)
    path = Path(sys.modules[f"deep_{next(numbers) - 2}"].__file__)
    path.write_text(f"{DEEP}\n\ndef added(x):\n    return x\n")
    assert translate.llvm_ir(whole)  # nothing that is translated
    path.write_text(DEEP.replace("slope * x", "slope - x"))
    with pytest.raises(
        translate.NotTranslatedError, match=r"deep.curve: .* was changed after it was imported"
    ):
        translate.llvm_ir(whole)
