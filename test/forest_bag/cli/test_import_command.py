"""A measured log becomes a bag of our topics, in SI units; what is wrong with it is named with its line."""

import math
import re
import textwrap
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")

from forest_bag.cli.main import main
from forest_bag.convert.log_map import read_map
from forest_bag.read.timeseries import read_bag
from forest_msgs_py.interfaces import topics

LOG = """\
    # somebody's machine
    t;boom angle;p1;handle
    0,000;90;100;0,5
    50,5;0;;-0,25
    100;-90;300;0
    """
MAP = """\
    file: {decimal: ","}
    time: {column: t, unit: ms, start: 1700000000}
    topics:
      joint_states:
        boom.position: {column: boom angle, unit: deg, scale: -1, offset: 90}
      /hydraulics/pressures:
        boom_1_actuator: {column: p1, unit: bar}
        boom_2_actuator: {value: 3000, unit: psi}
      joy:
        left_x: {column: handle}
        button_left_shoulder: {value: 1}
    """


@pytest.fixture
def convert(tmp_path, capsys):
    """Imports a log with a map; gives exit code, the bag's directory and what was said."""

    def run(log=LOG, mapping=MAP):
        (tmp_path / "log.csv").write_text(textwrap.dedent(log), encoding="utf-8-sig")
        (tmp_path / "map.yaml").write_text(textwrap.dedent(mapping), encoding="utf-8")
        code = main(["from-csv", str(tmp_path / "log.csv"), "--map", str(tmp_path / "map.yaml")])
        said = capsys.readouterr()
        return code, tmp_path / "log", said.out + said.err

    return run


def test_columns_become_signals_in_si_units(convert):
    code, directory, text = convert()
    assert code == 0, text
    assert "3 rows, 0.100 s" in text
    assert "1 cells empty" in text
    bag = read_bag(directory)
    start = 1_700_000_000 * 10**9
    joints = bag.series(topics.JOINT_STATES)
    np.testing.assert_array_equal(joints.time_ns, [start, start + 50_500_000, start + 100_000_000])
    np.testing.assert_array_equal(joints.log_time_ns, joints.time_ns)
    np.testing.assert_allclose(joints.column("boom.position"), [0.0, math.pi / 2, math.pi])
    assert joints.labels == ("boom.position",)
    pressures = bag.series(topics.PRESSURES)
    np.testing.assert_allclose(pressures.column("boom_1_actuator"), [1e7, np.nan, 3e7])
    np.testing.assert_allclose(pressures.column("boom_2_actuator"), 3000 * 6894.7)
    joy = bag.series(topics.JOY)
    np.testing.assert_allclose(joy.column("left_x"), [0.5, -0.25, 0.0])
    np.testing.assert_array_equal(joy.column("button_left_shoulder"), 1.0)
    np.testing.assert_array_equal(joy.column("right_y"), 0.0)


def test_the_same_log_gives_the_same_bag(convert, tmp_path):
    convert()
    (tmp_path / "log").rename(tmp_path / "first")
    convert()
    assert main(["compare", str(tmp_path / "first"), str(tmp_path / "log")]) == 0


def test_samples_may_come_at_a_rate_and_columns_without_names(convert):
    mapping = """\
        file: {header: false}
        time: {rate: 50, unit: Hz}
        topics: {valve_voltages: {swing: {column: 2, unit: mV}}}
        """
    code, directory, text = convert("1,1000\n2,2000\n", mapping)
    assert code == 0, text
    series = read_bag(directory).series(topics.VALVE_VOLTAGES)
    np.testing.assert_array_equal(series.time_ns, [0, 20_000_000])
    np.testing.assert_allclose(series.column("swing"), [1.0, 2.0])


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("column: t,", "column: time,", "no column 'time'; it has t, boom angle, p1, handle"),
        ("unit: deg", "unit: bar", "topics.joint_states.boom.position: unit 'bar'; allowed: rad, deg"),
        ("boom.position:", "bucket.position:", "has bucket.position; allowed: boom.effort"),
        ("joint_states:", "joints:", "no topic 'joints'; allowed: joy, joint_states"),
        ("column: handle", "colum: handle", "has colum; allowed: column, offset, scale"),
        ("unit: ms, start", "unit: ms, rate: 3, start", "time has column and rate, or neither"),
        ("unit: ms, start: 1700000000", "unit: s, start: 4e9", "allowed: 0 .. 2147483647 s"),
        (
            "topics:",
            "checks: {rate: {value: 50}}\n    topics:",
            "median rate 20 Hz; the map allows 50 Hz ± 5 %",
        ),
        (
            "topics:",
            "checks: {rate: {value: 50, percent: -1}}\n    topics:",
            "checks.rate.percent is -1; allowed: 0 or more",
        ),
        ("topics:", "checks: {max_gap: {value: 40, unit: ms}}\n    topics:", ":4: 0.0505 s without a row"),
        ("topics:", "topics: [", "not YAML"),
    ],
)
def test_a_wrong_map_is_named(convert, old, new, problem):
    assert old in MAP
    code, directory, text = convert(mapping=MAP.replace(old, new, 1))
    assert code == 1
    assert problem in text
    assert text.count("\n") == 1
    assert not directory.exists()


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("50,5;0;;", "50,5;zero;;", "log.csv:4: boom angle is 'zero'; allowed: a number, or nothing"),
        ("50,5;", "0;", "log.csv:4: time is 0 s after 0 s; times must rise"),
        ("50,5;0;;-0,25", "50,5;0", "log.csv:4: 2 cells; allowed: 4, as in the first row"),
        (";0,5", ";1,5", "log.csv:3: left_x is 1.5; allowed: -1 .. 1"),
        (";0,5", ";", "log.csv:3: left_x is empty; allowed: -1 .. 1"),
    ],
)
def test_a_wrong_log_is_named_with_its_line(convert, old, new, problem):
    assert old in LOG
    code, _, text = convert(LOG.replace(old, new, 1))
    assert code == 1
    assert problem in text


def test_an_existing_bag_is_kept(convert):
    assert convert()[0] == 0
    code, _, text = convert()
    assert code == 1
    assert "exists; allowed: a directory to be made" in text


def test_the_documented_maps_are_read(tmp_path):
    page = Path(__file__).resolve().parents[3] / "docs" / "reference" / "bags.md"
    text = page.read_text(encoding="utf-8")
    examples = [one for one in re.findall(r"```yaml\n(.*?)```", text, re.DOTALL) if "time:" in one]
    assert len(examples) == 2
    for number, example in enumerate(examples):
        file = tmp_path / f"{number}.yaml"
        file.write_text(example, encoding="utf-8")
        mapping = read_map(file)
        assert topics.JOY in mapping.topics
    assert mapping.topics[topics.JOY]["right_y"].column == "boom"
