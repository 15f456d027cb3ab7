"""What scripts/mutate.sh is told stays true while the code moves on."""

import importlib
import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
MODULES, SAMPLED, SURVIVORS, UNNOTICED = (
    yaml.safe_load((ROOT / f"test/mutation/{name}.yaml").read_text("utf-8"))
    for name in ("modules", "sampled", "survivors", "unnoticed")
)
PAGE = (ROOT / "docs/explanation/safety-evidence.md").read_text("utf-8")
ROOMS = {room: tests for rooms in SAMPLED.values() for room, tests in rooms.items()}
WHOLE = {  # what a group's rooms are
    "translator": ("forest_compile/forest_compile", ("", "frontend", "ir")),
    "lockstep": ("forest_msgs_py/forest_msgs_py", ("clock",)),
    "bags": ("forest_bag/forest_bag", ("storage", "write", "recovery")),
    "physics": (
        "forest_sim/forest_sim",
        ("mechanics", "hydraulics", "equations", "solver", "midpoint", "stage"),
    ),
    "estimators": (
        "forest_ident/forest_ident",
        ("estimators", "output_error", "refinement", "model_choice", "validation"),
    ),
}


def group_of(module):
    return next(
        group for group, rooms in SAMPLED.items() if module in rooms or str(Path(module).parent) in rooms
    )


def lines_of(module):
    """The module's lines as a mutant's key has them: without comment, single spaces."""
    return {
        " ".join(line.split("  #")[0].split())
        for line in (ROOT / "src" / module).read_text("utf-8").splitlines()
    }


@pytest.mark.parametrize("module", MODULES)
def test_modules_and_their_tests_are_there(module):
    assert (ROOT / "src" / module).is_file()
    assert MODULES[module]
    for test in MODULES[module]:
        assert (ROOT / "test" / test.partition("::")[0]).is_file()


@pytest.mark.parametrize("room", ROOMS)
def test_sampled_rooms_have_modules_and_tests(room):
    assert (
        (ROOT / "src" / room).is_file() if room.endswith(".py") else list((ROOT / "src" / room).glob("*.py"))
    )
    assert ROOMS[room] or room.endswith(".py")
    for test in ROOMS[room]:
        assert (ROOT / "test" / test.partition("::")[0]).exists()


@pytest.mark.parametrize("group", SAMPLED)
def test_a_group_is_sampled_in_all_its_rooms(group):
    package, rooms = WHOLE[group]
    assert {f"{package}/{room}".rstrip("/") for room in rooms} == {
        room for room in SAMPLED[group] if not room.endswith(".py")
    }


@pytest.mark.parametrize(
    ("listed", "module"), [(one, module) for one in (SURVIVORS, UNNOTICED) for module in one]
)
def test_every_survivor_that_is_listed_stands_in_the_module_and_has_a_reason(listed, module):
    lines = lines_of(module)
    assert module in MODULES or group_of(module)
    for keys in listed[module].values():
        for key, reason in keys.items():
            line = re.sub(r"«(.*?) → .*?»", r"\1", key.partition("  #")[0])
            assert line in lines, key
            assert len(reason) > 10, key


def test_a_module_is_listed_once():
    """Of two of one name YAML keeps the last."""
    for name in ("modules", "sampled", "survivors", "unnoticed"):
        text = (ROOT / f"test/mutation/{name}.yaml").read_text("utf-8")
        keys = re.findall(r"^ *(\S+\.py):", text, re.MULTILINE)
        assert len(keys) == len({*keys}), name


def rows_of(head):
    """The rows of the page's table whose head begins so, cell by cell."""
    table = PAGE[PAGE.index(head) :].partition("\n\n")[0]
    return [[cell.strip(" `") for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def test_the_table_of_safety_code_adds_up():
    *rows, total = ([name, *map(int, rest)] for name, *rest in rows_of("| module | mutants |"))
    for _, mutants, killed, explained, survived in (*rows, total):
        assert mutants == killed + explained + survived
    assert total == ["all", *(sum(row[k] for row in rows) for k in range(1, 5))]


def test_the_table_of_samples_is_right_and_each_survivor_is_listed(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "test/mutation")
    sample = importlib.import_module("sample")
    rows = [sample.Row(group, *map(int, numbers)) for group, *numbers, _ in rows_of("| group | seed |")]
    assert [row.group for row in rows] == [*SAMPLED]
    assert sample.table(rows) in PAGE
    for row in rows:
        listed = [
            keys for module, of in UNNOTICED.items() if group_of(module) == row.group for keys in of.values()
        ]
        assert sum(map(len, listed)) == row.drawn - row.explained - row.caught


def test_a_share_has_wilsons_interval(monkeypatch):
    """By hand: its ends x are where (x - p)^2 = 1.96^2 x (1 - x) / n."""
    monkeypatch.syspath_prepend(ROOT / "test/mutation")
    row = importlib.import_module("sample").Row("any", 1, 1000, 62, 2, 54)
    for x in row.interval():
        assert (x - 0.9) ** 2 == pytest.approx(1.96**2 * x * (1.0 - x) / 60)
    assert row.interval() == pytest.approx((0.799, 0.953), abs=1e-3)
