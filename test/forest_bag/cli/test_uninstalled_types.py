"""Messages of a type that is not installed are used by every verb if the bag holds the definition."""

import csv
import struct

import pytest

pytest.importorskip("rclpy")

from forest_bag.cli.main import main
from forest_bag.storage.mcap_file import McapFile
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.definitions import message_definition
from forest_msgs_py.serialization.cdr import ENCAPSULATION, to_cdr

GAUGE = "acme_msgs/msg/Gauge"  # of nobody's package
DEFINITION = f"""\
uint8 OK=0
std_msgs/Header header
string place
float32 reading  # [bar]
acme_msgs/Range[] ranges
{"=" * 80}
MSG: acme_msgs/Range
int16 low
int16 high
{"=" * 80}
MSG: std_msgs/Header
{message_definition("std_msgs/msg/Header")}"""
N = 5
PERIOD = 10_000_000


def gauge(step, reading):
    header = struct.pack("<iI", 0, step * PERIOD) + struct.pack("<I8s", 8, b"machine\0")
    place = struct.pack("<I8s", 5, b"pump\0")
    return ENCAPSULATION + header + place + struct.pack("<fIhhhh", reading, 2, -1, 1, -2, step)


@pytest.fixture
def make_gauges(tmp_path):
    """Writes a bag of gauge and flow messages; as somebody else's recorder would, with the definition."""

    def make(name, last=0.5, text=DEFINITION):
        file = McapFile(tmp_path / f"{name}.mcap")
        flows_type = file.add_schema(
            topics.FLOWS.type, "ros2msg", message_definition(topics.FLOWS.type).encode()
        )
        channels = [
            file.add_channel("/gauge", file.add_schema(GAUGE, "ros2msg", text.encode()), {}),
            file.add_channel("/hydraulics/flows", flows_type, {}),
        ]
        for step in range(N):
            flows = to_cdr(messages.float_array(topics.FLOWS, step * PERIOD, (1.0, 2.0)))
            contents = gauge(step, last if step == N - 1 else 0.25 * step), flows
            for channel, data in zip(channels, contents, strict=True):
                file.add_message(channel, step * PERIOD, data, step * PERIOD, step + 1)
        file.finish()
        return tmp_path / f"{name}.mcap"

    return make


def test_its_numbers_come_into_the_table_at_their_stamps(make_gauges, tmp_path, capsys):
    assert main(["to-csv", str(make_gauges("a")), "--topics", "/gauge", "-o", str(tmp_path / "t.csv")]) == 0
    assert capsys.readouterr().err == ""
    with (tmp_path / "t.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [int(row["stamp[ns]"]) for row in rows] == [step * PERIOD for step in range(N)]
    assert [float(row["gauge/reading"]) for row in rows] == [0.0, 0.25, 0.5, 0.75, 0.5]
    assert [float(row["gauge/ranges_1.high"]) for row in rows] == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert not any("place" in name or "OK" in name for name in rows[0])


def test_without_a_definition_it_is_left_out_with_a_word(make_gauges, capsys):
    for text in ("", "float64 ["):
        assert main(["to-csv", str(make_gauges(f"no{len(text)}", text=text))]) == 0
        out, err = capsys.readouterr()
        assert "left out: /gauge: acme_msgs/msg/Gauge is not installed here" in err
        assert "gauge" not in out


def test_two_bags_of_it_are_compared_number_by_number(make_gauges, capsys):
    a, b = make_gauges("a"), make_gauges("b", last=1.5)
    assert main(["compare", str(a), str(b)]) == 1
    assert "message 4 at 0.040000000 s: reading 0.5 and 1.5" in capsys.readouterr().out


def test_the_other_topics_are_drawn(make_bag, make_gauges, tmp_path, capsys):
    flows = [(t, messages.float_array(topics.PRESSURES, t, (1e6,) * 12)) for t in (1, 2, 3)]
    whole = make_bag({topics.PRESSURES: flows, topics.unlisted("/gauge", GAUGE): [(2, gauge(0, 1.0))]})
    assert main(["plot", str(whole), "-o", str(tmp_path / "pictures")]) == 0
    assert capsys.readouterr().out == f"{tmp_path / 'pictures' / 'hydraulics.png'}\n"


def test_play_publishes_the_others_and_names_it(make_gauges, domain_id, start_process):
    """ROS cannot publish a type without its compiled package, whatever the bag holds."""
    process = start_process(
        ["-m", "forest_bag.cli.main", "play", str(make_gauges("a")), "--rate", "0", "--delay", "0"]
    )
    assert process.wait(30) == 0, process.text()
    assert f"/gauge is not played: its type {GAUGE} is not installed here" in process.text()
    assert f"played {N} messages" in process.text()
