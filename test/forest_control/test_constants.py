"""Every number at the top of a module of forest_control tells its unit and its reason."""

import ast
import io
import re
import tokenize
from pathlib import Path

import pytest

import forest_control

PACKAGE = Path(forest_control.__file__).parent
MODULES = sorted(path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py"))
TOLD = re.compile(r"# \[[^\]]+\] \S+( \S+){3,}")  # a unit, and four words at the least


def is_number(value):
    """Whether an expression is a number, or a tuple of numbers; names alone are other constants, or types."""
    if isinstance(value, ast.Constant):
        return isinstance(value.value, (int, float)) and not isinstance(value.value, bool)
    if isinstance(value, ast.Tuple):
        return bool(value.elts) and all(map(is_number, value.elts))
    if isinstance(value, ast.UnaryOp):
        return is_number(value.operand)
    if isinstance(value, ast.BinOp):
        sides = [is_number(side) for side in (value.left, value.right)]
        names = [isinstance(side, ast.Name) for side in (value.left, value.right)]
        return any(sides) and all(number or name for number, name in zip(sides, names, strict=True))
    return ast.unparse(value) in ("math.inf", "math.nan", "math.pi")


def untold(source):
    """The numbers at the top of a module whose comment, on their last line, lacks unit or reason."""
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    comments = {token.start[0]: token.string for token in tokens if token.type == tokenize.COMMENT}
    return [
        ast.unparse(statement)
        for statement in ast.parse(source).body
        if isinstance(statement, (ast.Assign, ast.AnnAssign))
        and statement.value is not None
        and is_number(statement.value)
        and not TOLD.match(comments.get(statement.end_lineno, ""))
    ]


@pytest.mark.parametrize("module", MODULES)
def test_every_constant_has_a_unit_and_a_reason(module):
    assert not untold((PACKAGE / module).read_text("utf-8"))


@pytest.mark.parametrize(
    "line",
    [
        "LAG = 0.2",
        "LAG = 0.2  # of the low-pass that decides about opening",
        "LAG = 0.2  # [s]",
        "LAG = 0.2  # [s] chosen",
        "LAG: float = -0.2",
        "LAG = 2.0 * math.pi * 10.0",
        "LAG = math.inf",
        "LAG, LEAD = 0.2, 0.1",
        "LAG = LEAD**3",
        "LAG = LEAD = 1",
    ],
)
def test_a_number_without_unit_or_reason_is_found(line):
    assert untold(line)


@pytest.mark.parametrize(
    "line", ["LAG = 0.2  # [s] of the low-pass: chosen; not measured", "NAME = 'lag'", "ON = True", "A = B"]
)
def test_what_tells_both_and_what_is_no_number_passes(line):
    assert not untold(line)


def test_the_numbers_of_a_room_are_seen():
    source = (PACKAGE / "valve" / "valve_hold.py").read_text("utf-8")
    assert len(untold(re.sub(r"#.*", "", source))) == 7
