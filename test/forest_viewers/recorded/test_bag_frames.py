"""A bag with frames: nothing of it is lost, and what is added is what the crane did."""

from pathlib import Path

import numpy as np
import pytest
from bag_fixtures import make_bag
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.interfaces import topics
from forest_viewers import cli

__all__ = ["make_bag"]

BAG = Path(__file__).resolve().parents[3] / "bags" / "coordinated"


def messages(bag, *names):
    """Return topic, log time and message of some topics, as a reader that is not ours decodes them."""
    with AnyReader([Path(bag)], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        wanted = [connection for connection in reader.connections if connection.topic in names or not names]
        return [
            (connection.topic, time, reader.deserialize(data, connection.msgtype) if names else bytes(data))
            for connection, time, data in reader.messages(wanted)
        ]


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    output = tmp_path_factory.mktemp("frames") / "shown"
    assert cli.main(["frames", str(BAG), "-o", str(output)]) == 0
    return output


def test_every_recorded_message_is_there_as_it_was(shown):
    added = {"/tf", "/tf_static", "/viewer/joint_states"}
    assert [m for m in messages(shown) if m[0] not in added] == messages(BAG)


def test_the_frames_lead_to_the_tip_that_the_joints_give(shown):
    told = messages(shown, "/tf", "/tf_static", "/viewer/joint_states")
    (static,) = (message for topic, _, message in told if topic == "/tf_static")
    assert [frame.child_frame_id for frame in static.transforms][-1] in {"tip", "head"}
    joints = {stamp(message.header): message for topic, _, message in told if "joint" in topic}
    moved = [message for topic, _, message in told if topic == "/tf"]
    links = load_machine("c180_hoses").manipulator.links
    assert len(moved) > 10
    for message in moved[::7]:
        frames = {frame.child_frame_id: frame.transform for frame in message.transforms}
        place = np.zeros(3)
        tip = next(frame for frame in static.transforms if frame.child_frame_id == "tip").transform
        for transform in (tip, frames["stick"], frames["boom"], frames["platform"]):
            place = _placed(transform, place)
        q = tuple(joints[stamp(message.transforms[0].header)].position[:3])
        np.testing.assert_allclose(place, tip_position(q, links), atol=1e-9)


def test_a_bag_with_frames_gets_no_second_ones(shown, tmp_path, capsys):
    assert cli.main(["frames", str(shown), "-o", str(tmp_path / "again")]) == 1
    assert "has /tf" in capsys.readouterr().err
    assert not (tmp_path / "again").exists()


def test_a_bag_that_holds_its_machine_needs_no_name_of_it(make_bag, tmp_path):
    pytest.importorskip("rclpy")
    from sensor_msgs.msg import JointState
    from std_msgs.msg import String

    text = (
        "name: long\nbased_on: c180_hoses\nmanipulator: {boom_length: {value: 4.0, unit: m, source: drawn}}\n"
    )
    (tmp_path / "long.yaml").write_text(text)
    urdf = String(data=robot_description(load_machine(tmp_path / "long.yaml")))
    state = JointState(name=["swing", "boom", "stick"], position=[0.1, 0.5, -1.0])
    content = {topics.ROBOT_DESCRIPTION: [(1, urdf)], topics.JOINT_STATES: [(2, state)]}
    bag, output = make_bag(content, files=[("machine/long.yaml", text)]), tmp_path / "shown"
    assert cli.main(["frames", str(bag), "-o", str(output)]) == 0
    assert len(messages(output, "/tf")) == 1


def test_the_layouts_are_found(capsys):
    assert cli.main(["layouts"]) == 0
    assert "foxglove.json" in capsys.readouterr().out


def stamp(header):
    return header.stamp.sec, header.stamp.nanosec


def _placed(transform, point):
    """Return a point of the child's frame in the parent's."""
    t, r = transform.translation, transform.rotation
    u, w = np.array([r.x, r.y, r.z]), r.w
    turned = point + 2.0 * np.cross(u, np.cross(u, point) + w * point)
    return turned + np.array([t.x, t.y, t.z])
