"""A bag becomes a table that is joined on stamps, with units, and pictures."""

import csv

import pytest

pytest.importorskip("rclpy")

from std_msgs.msg import String

from forest_bag.cli.main import main
from forest_bag.cli.plot_command import joint_limits
from forest_bag.read.bag_reader import BagReader
from forest_msgs_py.interfaces import messages, topics

PERIOD = 5_000_000
N = 6
URDF = (
    '<robot><joint name="boom"><limit lower="-0.5" upper="1.25"/></joint>'
    '<joint name="swing"/><joint name="hose"><limit lower="0" upper="1"/></joint></robot>'
)


@pytest.fixture
def bag(make_bag):
    """Flows at each stamp, pressures (one of them missing) and voltages at each second."""
    times = [1_000_000_000 + PERIOD * step for step in range(N)]
    supply = dict.fromkeys(times[::2], (1.0 / 3.0, 2.0, 3.0))
    return make_bag(
        {
            topics.FLOWS: [(t, messages.float_array(topics.FLOWS, t, (t / 1e9, 0.1))) for t in times],
            topics.SUPPLY: [(t, messages.float_array(topics.SUPPLY, t, v)) for t, v in supply.items()],
            topics.VALVE_VOLTAGES: [
                (t, messages.float_array(topics.VALVE_VOLTAGES, t, (1.0, 2.0, 3.0))) for t in times[::2]
            ],
            topics.ROBOT_DESCRIPTION: [(times[0], String(data=URDF))],
        },
    )


def table(path):
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_rows_are_stamps_and_columns_have_units(bag, tmp_path, capsys):
    out = tmp_path / "t.csv"
    assert main(["to-csv", str(bag), "-o", str(out)]) == 0
    rows = table(out)
    assert [int(row["stamp[ns]"]) for row in rows] == [1_000_000_000 + PERIOD * step for step in range(N)]
    assert [float(row["time[s]"]) for row in rows] == [0.005 * step for step in range(N)]
    assert float(rows[3]["hydraulics/flows/swing_1[m³/s]"]) == 1.015
    pressure = [row["hydraulics/supply/pressure[Pa]"] for row in rows]
    assert [float(cell) if cell else None for cell in pressure] == [1.0 / 3.0, None] * 3
    assert "left out: /robot_description" in capsys.readouterr().err


def test_cells_may_be_held_and_rows_taken_from_one_topic(bag, tmp_path):
    held, at = tmp_path / "held.csv", tmp_path / "at.csv"
    assert main(["to-csv", str(bag), "--hold", "-o", str(held)]) == 0
    assert all(row["hydraulics/supply/pressure[Pa]"] for row in table(held))
    flags = ["--at", "/hydraulics/supply", "--topics", "/hydraulics/flows"]
    assert main(["to-csv", str(bag), *flags, "-o", str(at)]) == 0
    assert list(table(at)[0])[2:] == ["hydraulics/flows/swing_1[m³/s]", "hydraulics/flows/stick_1[m³/s]"]
    assert len(table(at)) == N // 2


def test_parquet_holds_the_same_with_units_in_the_fields(bag, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    out = tmp_path / "t.parquet"
    assert main(["to-parquet", str(bag), "-o", str(out)]) == 0
    read = parquet.read_table(out)
    assert read.column("hydraulics/supply/pressure[Pa]").to_pylist() == [1.0 / 3.0, None] * 3
    assert read.schema.field("hydraulics/supply/pressure[Pa]").metadata == {b"unit": b"Pa"}


def test_without_pyarrow_the_way_out_is_named(bag, monkeypatch, capsys):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    assert main(["to-parquet", str(bag)]) == 1
    assert "pip install 'forest-crane[parquet]', or to-csv" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("flags", "problem"),
    [
        (["--topics", "/nothing"], "no topic '/nothing'; the bag holds /hydraulics/flows"),
        (["--topics", "/robot_description"], "no numbers in the bag"),
        (["--at", "/robot_description"], "no numbers on '/robot_description'; they are on /hydraulics/flows"),
    ],
)
def test_what_is_not_in_the_bag_is_named(bag, capsys, flags, problem):
    assert main(["to-csv", str(bag), *flags]) == 1
    assert problem in capsys.readouterr().err


def test_nothing_is_overwritten(bag, tmp_path, capsys):
    out = tmp_path / "t.csv"
    out.write_text("mine")
    assert main(["to-csv", str(bag), "-o", str(out)]) == 1
    assert "exists; allowed: a file to be made" in capsys.readouterr().err
    assert out.read_text() == "mine"


def test_pictures_are_drawn_of_what_is_there(bag, tmp_path, capsys):
    out = tmp_path / "pictures"
    assert main(["plot", str(bag), "-o", str(out)]) == 0
    assert capsys.readouterr().out == f"{out / 'voltages.png'}\n"
    assert (out / "voltages.png").stat().st_size > 10_000
    with BagReader(bag) as reader:
        assert joint_limits(reader) == {"boom": (-0.5, 1.25)}


def test_a_bag_without_our_topics_is_refused(make_bag, tmp_path, capsys):
    bag = make_bag({topics.unlisted("/chatter", "std_msgs/msg/String"): [(1, String(data="hi"))]}, "theirs")
    assert main(["plot", str(bag), "-o", str(tmp_path / "p")]) == 1
    assert "holds none of the topics that are drawn" in capsys.readouterr().err
