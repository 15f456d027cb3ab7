"""Any bag is opened as far as it can be read: of any recorder, damaged, without stamps, hostile."""

import contextlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rclpy")

from sensor_msgs.msg import Joy
from std_msgs.msg import String

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_description.machine import load_machine
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.topics import unlisted
from forest_station.recordings.replay_bag import LARGEST_URDF, LONGEST_TEXT, MOST_EVENTS, ReplayBag
from forest_station.recordings.replay_frames import frames, matrix, window

OWN = load_machine("c180_hoses")
REFERENCE = Path("bags/coordinated")
START = 1_700_000_000_000_000_000
PERIOD = 5_000_000
N = 400
WANTED, ENOUGH = window(0.5, 2.0, 30.0), 3_000_000_000


@pytest.fixture
def opened():
    """Opens bags, whose description the page can read."""
    with contextlib.ExitStack() as closed:

        def open_one(path):
            bag = closed.enter_context(contextlib.closing(ReplayBag(path, OWN)))
            json.dumps(bag.description(), allow_nan=False)
            return bag

        yield open_one


@pytest.fixture(scope="module")
def ours():
    """Signals and frames of the reference bag as it was recorded."""
    with contextlib.closing(ReplayBag(REFERENCE, OWN)) as bag:
        return list(bag.units.items()), frames(bag, WANTED)


def joint_states(angle=lambda step: 0.001 * step):
    return [
        (
            START + PERIOD * step,
            messages.joint_state(topics.JOINTS, START + PERIOD * step, (angle(step), 0.5, -1.0), (0.0,) * 3),
        )
        for step in range(N)
    ]


@pytest.mark.parametrize(("storage", "mode"), [("SQLITE3", "NONE"), ("SQLITE3", "FILE"), ("MCAP", "MESSAGE")])
def test_a_bag_of_rosbag2_shows_the_same_frames(tmp_path, storage, mode, opened, ours):
    from rosbags import rosbag2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_JAZZY)
    writer = rosbag2.Writer(
        tmp_path / "bag", version=9, storage_plugin=getattr(rosbag2.StoragePlugin, storage)
    )
    if mode != "NONE":
        writer.set_compression(getattr(rosbag2.CompressionMode, mode), rosbag2.CompressionFormat.ZSTD)
    with BagReader(REFERENCE) as reader, writer:
        connections = {
            name: writer.add_connection(name, channels[0].type, typestore=store)
            for name, channels in reader.channels.items()
            if channels[0].type in store.types
        }
        messages = list(reader.messages(connections))
        for message in messages:
            if message.log_ns < messages[0].log_ns + ENOUGH:
                writer.write(connections[message.channel.topic], message.log_ns, message.data)
    theirs = opened(tmp_path / "bag")
    assert (list(theirs.units.items()), frames(theirs, WANTED)) == ours


def test_of_a_damaged_bag_is_shown_what_is_whole_and_said_what_is_wrong(tmp_path, opened):
    whole, cut = REFERENCE / "coordinated_0.mcap", tmp_path / "cut.mcap"
    data = whole.read_bytes()
    cut.write_bytes(data[: len(data) // 2])
    bag, complete = opened(cut), opened(REFERENCE)
    assert any("it has no end" in note for note in bag.description()["notes"])
    assert 1.5 < bag.seconds < 4.0
    wanted = window(0.0, bag.seconds - 0.2, 30.0)
    ours = [list(complete.units).index(name) for name in bag.units]
    np.testing.assert_array_equal(matrix(bag, wanted), matrix(complete, wanted)[:, ours])


def test_of_a_killed_recording_nothing_is_missing(make_bag, opened):
    bag = opened(make_bag({topics.JOINT_STATES: joint_states()}, closed=False))
    assert bag.seconds == pytest.approx((N - 1) * PERIOD * 1e-9)
    place = list(bag.units).index("joint_states/swing.position")
    values = matrix(bag, window(0.0, 1.9, 200.0))[:, place]
    np.testing.assert_allclose(values, 0.001 * np.arange(380))


def test_messages_without_stamps_are_shown_at_their_log_times(make_bag, opened):
    logged = [(START + PERIOD * step, Joy(axes=[step / N, 0.0], buttons=[1])) for step in range(N)]
    bag = opened(make_bag({topics.JOY: logged}))
    values = matrix(bag, window(0.0, 1.0, 200.0))
    np.testing.assert_allclose(values[:, list(bag.units).index("joy/left_x")], np.arange(200) / N, atol=1e-7)
    assert "crane/boom_cylinder_rod.position" not in bag.units  # nobody says where the joints are


def test_a_namespace_is_dropped_so_that_the_page_knows_the_signals(make_bag, opened):
    bag = opened(make_bag({topics.JOINT_STATES: joint_states()}, namespace="/crane_1"))
    assert "joint_states/boom.position" in bag.units


def test_two_cranes_keep_their_names(make_bag, opened):
    second = unlisted("/crane_2/joint_states", topics.JOINT_STATE)
    bag = opened(
        make_bag({topics.JOINT_STATES: joint_states(), second: joint_states()}, namespace="/crane_1")
    )
    assert {"crane_1/joint_states/boom.position", "crane_2/joint_states/boom.position"} <= set(bag.units)


@pytest.mark.parametrize("machine", ["c180_hoses", "loader"])
def test_a_recorded_crane_has_its_own_scene_and_its_cylinders_lie_as_its_machine_says(
    make_bag, machine, opened
):
    from forest_station.scene.crane_signals import crane_signals

    urdf = robot_description(load_machine(machine))
    bag = opened(
        make_bag(
            {topics.ROBOT_DESCRIPTION: [(START, String(data=urdf))], topics.JOINT_STATES: joint_states()}
        )
    )
    scene = bag.description()["scene"]
    assert (scene is None) == (machine == "c180_hoses")  # the station's own crane is drawn already
    expected = crane_signals(load_machine(machine), {"swing": 0.1, "boom": 0.5, "stick": -1.0})
    row = dict(zip(bag.units, matrix(bag, window(0.5, 0.504, 200.0))[0].tolist(), strict=True))
    np.testing.assert_allclose([row[name] for name in expected], list(expected.values()))


def test_a_machine_whose_file_is_in_the_bag_has_its_cylinders(make_bag, tmp_path, opened):
    text = "name: long\nbased_on: c180\nmanipulator: {boom_length: {value: 4.0, unit: m, source: drawn}}\n"
    (tmp_path / "long.yaml").write_text(text)
    urdf = robot_description(load_machine(tmp_path / "long.yaml"))
    content = {topics.ROBOT_DESCRIPTION: [(START, String(data=urdf))], topics.JOINT_STATES: joint_states()}
    bag = opened(make_bag(content, files=[("machine/long.yaml", text)]))
    assert bag.crane.machine.manipulator.boom_length == 4.0
    assert set(bag.crane.signals) <= set(bag.units)


@pytest.mark.parametrize("urdf", ["", "no xml", "<robot/>", "<a>" * 10_000, "x" * (LARGEST_URDF + 1)])
def test_a_robot_description_of_garbage_leaves_the_stations_crane(make_bag, urdf, opened):
    content = {topics.ROBOT_DESCRIPTION: [(START, String(data=urdf))], topics.JOINT_STATES: joint_states()}
    assert opened(make_bag(content)).description()["scene"] is None


def test_texts_of_a_bag_are_cut_and_counted(make_bag, opened):
    events = [(START + step, String(data="<script>" * 10_000)) for step in range(MOST_EVENTS + 10)]
    told = opened(make_bag({topics.EVENTS: events})).description()
    assert len(told["events"]) == MOST_EVENTS
    assert {len(text) for _, text in told["events"]} == {LONGEST_TEXT}


def test_a_late_topic_has_its_signals_and_is_unknown_before(make_bag, opened):
    """With a stream of 8000 messages before it, so that it is not met at the start."""
    late = [(START + 2 * N * PERIOD, messages.float_array(topics.FLOWS, START, (1.0, 2.0)))]
    bag = opened(make_bag({topics.JOINT_STATES: joint_states(), topics.FLOWS: late}))
    place = list(bag.units).index("hydraulics/flows/swing_1")
    values = matrix(bag, window(0.0, bag.seconds + 0.1, 30.0))[:, place]
    assert np.isnan(values[:-4]).all()
    assert values[-1] == 1.0


def test_what_is_no_bag_or_holds_nothing_is_refused_in_a_sentence(tmp_path, make_bag, opened):
    (tmp_path / "text.mcap").write_text("no bag")
    with pytest.raises(BagError, match="is not an MCAP file"):
        opened(tmp_path / "text.mcap")
    with pytest.raises(BagError, match="holds no message that can be read"):
        opened(make_bag({}, name="empty"))


def test_the_first_message_of_each_topic_is_told_to_align_bags_by(tmp_path, opened):
    shutil.copytree(REFERENCE, tmp_path / "bag")
    first = opened(tmp_path / "bag").description()["first"]
    assert first["robot_description"] == 0.0
    assert first["joint_states"] == 0.005
