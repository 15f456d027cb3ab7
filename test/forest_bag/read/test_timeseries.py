"""A bag comes back as the numbers that were written, also when its recorder was killed."""

import numpy as np
import pytest

pytest.importorskip("rclpy")

from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Joy
from std_msgs.msg import Float64MultiArray, String

from forest_bag.read.timeseries import NotInBag, read_bag
from forest_msgs_py.interfaces import messages, topics

START = 1_700_000_000_000_000_000
PERIOD = 5_000_000
N = 50
STAMPS = [START + PERIOD * step for step in range(N)]
LATER = 700_000  # how long after its stamp a message is logged, ns


def logged(make):
    return [(stamp + LATER, make(stamp, step)) for step, stamp in enumerate(STAMPS)]


@pytest.fixture
def content():
    return {
        topics.JOINT_STATES: logged(
            lambda stamp, step: messages.joint_state(
                topics.JOINTS, stamp, (step, 2.0 * step, 3.0 * step), (0.1, 0.2, 0.3)
            )
        ),
        topics.FLOWS: logged(lambda stamp, step: messages.float_array(topics.FLOWS, stamp, (step, -step))),
        topics.TIP_POSE: logged(
            lambda stamp, step: messages.pose_stamped(stamp, "base_link", (step, 1.0, 2.0))
        ),
        topics.TIP_TWIST: logged(
            lambda stamp, step: messages.twist_stamped(stamp, "base_link", (0.0, step, 0.0))
        ),
        topics.JOY: logged(
            lambda stamp, step: Joy(axes=[0.5, -1.0], buttons=[1])  # a stick with two axes and no stamp
        ),
        topics.CLOCK: logged(lambda stamp, step: Clock(clock=messages.ns_to_stamp(stamp))),
        topics.ROBOT_DESCRIPTION: [(START, String(data="<robot/>"))],
    }


@pytest.mark.parametrize(("namespace", "closed"), [("", True), ("/crane_1", True), ("", False)])
def test_what_was_written_comes_back_by_topic(content, make_bag, namespace, closed):
    bag = read_bag(make_bag(content, namespace=namespace, closed=closed))
    assert bag.complete == closed
    joints = bag.series(topics.JOINT_STATES)
    assert bag.name(topics.JOINT_STATES) == f"{namespace}/joint_states"
    np.testing.assert_array_equal(joints.time_ns, STAMPS)
    np.testing.assert_array_equal(joints.log_time_ns, np.add(STAMPS, LATER))
    np.testing.assert_array_equal(joints.column("boom.position"), 2.0 * np.arange(N))
    assert joints.labels[3:] == ("swing.velocity", "boom.velocity", "stick.velocity")
    assert joints.units == ("rad",) * 3 + ("rad/s",) * 3
    flows = bag.series(topics.FLOWS)
    np.testing.assert_array_equal(flows.values, np.column_stack([np.arange(N), -np.arange(N)]))
    np.testing.assert_array_equal(flows.time_ns, STAMPS)
    assert (flows.labels, flows.units) == (("swing_1", "stick_1"), ("m³/s", "m³/s"))
    np.testing.assert_array_equal(bag.series(topics.TIP_POSE).column("x"), np.arange(N))
    np.testing.assert_array_equal(bag.series(topics.TIP_TWIST).column("y"), np.arange(N))
    assert bag.series(topics.JOY).labels == ("left_x", "left_y", "button_a")
    np.testing.assert_array_equal(bag.series(topics.CLOCK).time_ns, STAMPS)


def test_counts_rates_and_losses_are_told(content, make_bag):
    bag = read_bag(make_bag(content))
    info = bag.topics["/joint_states"]
    assert (info.type, info.count, info.lost) == ("sensor_msgs/msg/JointState", N, 0)
    assert (info.first_ns, info.last_ns) == (STAMPS[0] + LATER, STAMPS[-1] + LATER)
    assert info.rate_hz == pytest.approx(200.0)
    assert bag.topics["/robot_description"].rate_hz == 0.0


def test_a_file_cut_off_anywhere_gives_its_finished_chunks(content, make_bag):
    directory = make_bag(content, closed=False)
    whole = (directory / "bag_0.mcap").read_bytes()
    count = len(read_bag(directory).series(topics.FLOWS).time_ns)
    cut = directory.parent / "cut.mcap"
    for missing in (1, 9, 100, 500):
        cut.write_bytes(whole[: len(whole) - missing])
        bag = read_bag(cut)
        assert not bag.complete
        if "/flows" in bag.topics:
            assert len(bag.series("/flows").time_ns) <= count
    cut.write_bytes(whole + whole[-40:])
    assert len(read_bag(cut).series(topics.FLOWS).time_ns) == count


def test_an_array_without_a_stamp_is_placed_by_its_log_time(make_bag):
    bare = Float64MultiArray(data=[1.0, 2.0, 3.0])
    bag = read_bag(make_bag({topics.VALVE_COMMANDS: [(START, bare), (START + 1, bare)]}))
    series = bag.series(topics.VALVE_COMMANDS)
    np.testing.assert_array_equal(series.time_ns, [START, START + 1])
    assert series.labels == topics.JOINTS


@pytest.mark.parametrize("first", [0, 1])
def test_a_sensor_that_drops_out_leaves_a_gap_and_nothing_else(make_bag, first):
    whole = messages.float_array(topics.FLOWS, START, (1.0, 2.0))
    partial = messages.float_array(topics.FLOWS, START, (3.0,), labels=("stick_1",))
    recorded = [(START, message) for message in (whole, partial, whole)[first:]]
    series = read_bag(make_bag({topics.FLOWS: recorded})).series(topics.FLOWS)
    np.testing.assert_array_equal(series.column("swing_1"), [1.0, np.nan, 1.0][first:])
    np.testing.assert_array_equal(series.column("stick_1"), [2.0, 3.0, 2.0][first:])
    assert (series.incomplete, len(series.time_ns)) == (1, 3 - first)


def test_what_is_not_in_the_bag_is_named(content, make_bag, tmp_path):
    bag = read_bag(make_bag(content))
    with pytest.raises(NotInBag, match="no topic 'hydraulics/supply'; the bag holds /clock"):
        bag.series(topics.SUPPLY)
    with pytest.raises(NotInBag, match=r"no column 'bucket'; there are swing_1, stick_1"):
        bag.series(topics.FLOWS).column("bucket")
    with pytest.raises(ValueError, match="has no series"):
        bag.series(topics.ROBOT_DESCRIPTION)
    with pytest.raises(FileNotFoundError, match="nowhere does not exist"):
        read_bag(tmp_path / "nowhere")
