"""Two bags are the same to the last bit, or the difference is named with its place."""

import json
import math

import pytest

pytest.importorskip("rclpy")

from rcl_interfaces.msg import Log
from std_msgs.msg import String

from forest_bag.cli.main import main
from forest_msgs_py.interfaces import messages, topics

PERIOD = 5_000_000
N = 40


def joints(stamp, boom):
    return messages.joint_state(topics.JOINTS, stamp, (0.1, boom, 0.3), (0.0,) * 3, (0.0,) * 3)


@pytest.fixture
def content():
    """A session in lockstep: log times are stamps."""
    times = [PERIOD * (step + 1) for step in range(N)]
    counts = [0.0] * len(topics.AUXILIARY.labels)
    return {
        topics.JOINT_STATES: [(time, joints(time, 0.01 * step)) for step, time in enumerate(times)],
        topics.AUXILIARY: [(time, messages.float_array(topics.AUXILIARY, time, counts)) for time in times],
        topics.ROBOT_DESCRIPTION: [(0, String(data="<robot/>"))],
        topics.ROSOUT: [(7, Log(msg="hello"))],
        topics.unlisted("/theirs", "nobody_msgs/msg/Secret"): [(9, b"\x00\x01\x00\x00abc")],
    }


@pytest.fixture
def compare(make_bag, content, tmp_path, capsys):
    """Compares the session with a changed one; gives exit code, text and JSON."""
    first = make_bag(content, "a")

    def run(changed, *flags):
        second = make_bag(content | changed, "b")
        code = main(["compare", str(first), str(second), "--json", str(tmp_path / "c.json"), *flags])
        found = json.loads((tmp_path / "c.json").read_text())
        by_topic = {topic["topic"]: topic for topic in found["topics"]}
        return code, capsys.readouterr().out, found | {"topics": by_topic}

    return run


def changed_at(content, step, **change):
    rows = list(content[topics.JOINT_STATES])
    time, _ = rows[step]
    rows[step] = (time + change.get("later", 0), joints(time, change.get("boom", 0.01 * step)))
    return {topics.JOINT_STATES: rows}


def test_the_same_bytes_are_the_same(compare):
    code, text, found = compare({})
    assert code == 0
    assert "are the same" in text
    assert found["same"]
    assert found["topics"]["/joint_states"]["pairs"] == N


def test_one_number_in_its_last_bit_is_a_difference_with_its_place(compare, content):
    changed = math.nextafter(0.07, 1.0)
    code, text, found = compare(changed_at(content, 7, boom=changed))
    assert code == 1
    assert "first difference: /joint_states, message 7 at 0.040000000 s: boom.position" in text
    topic = found["topics"]["/joint_states"]
    signal = next(s for s in topic["signals"] if s["label"] == "boom.position")
    assert (topic["differing"], topic["pairs"], signal["unit"]) == (1, N, "rad")
    assert signal["largest"] == changed - 0.07
    assert signal["largest_stamp_ns"] == 8 * PERIOD
    assert signal["rms"] == pytest.approx((changed - 0.07) / math.sqrt(N))
    assert [name for name, other in found["topics"].items() if not other["same"]] == ["/joint_states"]


@pytest.mark.parametrize(
    ("flags", "code"),
    [
        (["--tolerance", "0.02"], 0),
        (["--tolerance", "0.005"], 1),
        (["--tolerance", "/joint_states.boom.position=0.02"], 0),
        (["--tolerance", "1", "/joint_states=0.005"], 1),
        (["--ignore", "/joint_states"], 0),
        (["--topics", "/robot_description"], 0),
    ],
)
def test_the_tolerance_decides_and_is_given_by_topic_or_signal(compare, content, flags, code):
    assert compare(changed_at(content, 7, boom=0.08), *flags)[0] == code


def test_a_log_time_counts_unless_numbers_are_tolerated(compare, content):
    changed = changed_at(content, 7, later=1)
    code, text, found = compare(changed)
    assert code == 1
    assert "log time 0.040000000 s and 0.040000001 s" in text
    assert found["topics"]["/joint_states"]["differing_log_times"] == 1


def test_a_tolerance_forgives_log_times(compare, content):
    code, text, found = compare(changed_at(content, 7, later=1), "--tolerance", "1e-9")
    assert code == 0
    assert "first difference" not in text
    assert found["topics"]["/joint_states"]["first"] is None


@pytest.mark.parametrize("tolerance", ["0", "1e9"])
def test_a_missing_message_is_a_difference_and_the_rest_stays_paired(compare, content, tolerance):
    rows = content[topics.JOINT_STATES]
    code, text, found = compare({topics.JOINT_STATES: rows[:5] + rows[6:]}, "--tolerance", tolerance)
    assert code == 1
    assert "message 5 at 0.030000000 s: a message that is only in A" in text
    topic = found["topics"]["/joint_states"]
    assert (topic["alone"], topic["pairs"], topic["differing"]) == ([1, 0], N - 1, 0)


def test_a_sensor_that_only_one_bag_has_is_a_difference(compare, content):
    rows = list(content[topics.JOINT_STATES])
    rows[3] = (rows[3][0], messages.joint_state(("swing", "boom"), rows[3][0], (0.1, 0.03)))
    code, text, _ = compare({topics.JOINT_STATES: rows}, "--tolerance", "1e9")
    assert code == 1
    assert "stick.position" in text
    assert "only in A" in text


def test_a_changed_text_is_a_difference(compare):
    code, text, _ = compare({topics.ROBOT_DESCRIPTION: [(0, String(data="<robot>"))]}, "--tolerance", "1e9")
    assert code == 1
    assert "data '<robot/>' and '<robot>'" in text


def test_wall_clock_measurements_are_not_compared(compare, content):
    rows = list(content[topics.AUXILIARY])
    counts = [0.0] * len(topics.AUXILIARY.labels)
    counts[topics.AUXILIARY.labels.index("missed_deadlines")] = 3.0
    rows[9] = (rows[9][0], messages.float_array(topics.AUXILIARY, rows[9][0], counts))
    code, _, found = compare({topics.AUXILIARY: rows, topics.ROSOUT: [(8, Log(msg="good bye"))]})
    assert code == 0
    assert found["not_compared"] == ["/rosout"]


def test_a_relief_opening_beside_them_is(compare, content):
    rows = list(content[topics.AUXILIARY])
    counts = [0.0] * len(topics.AUXILIARY.labels)
    counts[topics.AUXILIARY.labels.index("relief_openings")] = 1.0
    rows[9] = (rows[9][0], messages.float_array(topics.AUXILIARY, rows[9][0], counts))
    assert compare({topics.AUXILIARY: rows})[0] == 1


def test_types_nobody_knows_are_compared_by_bytes(compare):
    secret = topics.unlisted("/theirs", "nobody_msgs/msg/Secret")
    code, text, _ = compare({secret: [(9, b"\x00\x01\x00\x00abd")]})
    assert code == 1
    assert "/theirs, message 0 at 0.000000009 s: bytes, from byte 6 on" in text


def test_a_topic_that_only_one_bag_has_is_a_difference(compare):
    clock = topics.message_class(topics.CLOCK)()
    code, text, found = compare({topics.CLOCK: [(5, clock)]})
    assert code == 1
    assert found["only_in_b"] == ["/clock"]
    assert "only in B" in text


def test_a_topic_that_was_only_announced_says_nothing(compare):
    code, _, found = compare({topics.CLOCK: []})
    assert (code, found["only_in_b"]) == (0, [])


def test_sessions_of_different_times_are_aligned(make_bag, content, tmp_path, capsys):
    def wave(origin, phase):
        times = [PERIOD * step for step in range(N)]
        return {
            topics.JOINT_STATES: [(origin + t, joints(origin + t, 2.0 * (t - phase) * 1e-9)) for t in times]
        }

    first, second = make_bag(wave(10**18, 0), "a"), make_bag(wave(2 * 10**18, PERIOD), "b")
    arguments = ["compare", str(first), str(second)]
    assert main(arguments) == 1
    assert "only in A" in capsys.readouterr().out
    picture = tmp_path / "c.png"
    aligned = [*arguments, "--align", "/joint_states", "--picture", str(picture)]
    assert main([*aligned, "--tolerance", "0.0100001"]) == 0
    assert main([*aligned, "--tolerance", "0.0099"]) == 1
    assert picture.stat().st_size > 10_000


def test_a_damaged_bag_is_refused_with_advice(make_bag, content, capsys):
    whole, damaged = make_bag(content, "a"), make_bag(content, "b", closed=False)
    assert main(["compare", str(whole), str(damaged)]) == 2
    error = capsys.readouterr().err
    assert "forest-bag recover" in error
    assert error.count("\n") == 1


def test_aligned_with_itself_a_bag_is_the_same_though_messages_share_a_stamp(make_bag, content):
    twice = [(time, joints(time, number)) for number, time in enumerate((10, 20, 20, 30))]
    bag = str(make_bag({topics.JOINT_STATES: twice}, "a"))
    assert main(["compare", bag, bag, "--align", "start"]) == 0


@pytest.mark.parametrize(
    ("flags", "problem"),
    [
        (["--topics", "/nothing"], "no topic '/nothing' in either bag; there are /hydraulics/auxiliary"),
        (
            ["--tolerance", "/nothing=1"],
            "--tolerance /nothing: no such topic; there are /hydraulics/auxiliary",
        ),
        (["--align", "/nothing"], "/nothing"),
        (["--json", "/dev/full"], "/dev/full: No space left"),
    ],
)
def test_what_is_wrong_is_named(make_bag, content, capsys, flags, problem):
    bag = str(make_bag(content, "a"))
    assert main(["compare", bag, bag, *flags]) == 2
    assert problem in capsys.readouterr().err


@pytest.mark.parametrize(
    ("flags", "allowed"),
    [
        (["--json", "/nowhere/c.json"], "a file in a directory that is there"),
        (["--picture", "c.bmp"], "a file that ends in .png, .pdf, .svg"),
    ],
)
def test_a_file_that_cannot_be_made_is_told_before_the_work(capsys, flags, allowed):
    with pytest.raises(SystemExit, match="2"):
        main(["compare", "a", "b", *flags])
    assert f"allowed: {allowed}" in capsys.readouterr().err


@pytest.mark.parametrize("tolerance", ["-1", "nan", "inf", "much", "/joy="])
def test_a_tolerance_is_a_number(capsys, tolerance):
    with pytest.raises(SystemExit, match="2"):
        main(["compare", "a", "b", f"--tolerance={tolerance}"])
    assert "allowed: a number of 0 or more" in capsys.readouterr().err
