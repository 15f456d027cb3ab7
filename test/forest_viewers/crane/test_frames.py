"""Frames of the links: against another rigid-body library, and as another reader decodes them."""

import numpy as np
import pinocchio
import pytest
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from forest_description.machine import load_machine
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.definitions import message_definition
from forest_msgs_py.serialization.transforms import pack_transforms
from forest_viewers.crane.frames import Transform, fixed_frames, moving_frames, urdf_joints
from forest_viewers.crane.whole_crane import joint_names

TURNED = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="first" type="revolute"><parent link="a"/><child link="b"/>
<origin xyz="1 2 3" rpy="0.3 -0.4 0.5"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="second" type="prismatic"><parent link="b"/><child link="c"/>
<origin xyz="0 1 0" rpy="-0.2 0.1 0.7"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


def placed(frames):
    """Return each frame in the root's, from frames in their parents'."""
    found = {}
    for frame in frames:
        here = pinocchio.XYZQUATToSE3(np.array([*frame.translation, *frame.rotation]))
        found[frame.child] = found.get(frame.parent, pinocchio.SE3.Identity()) * here
    return found


def expected(urdf, positions):
    model = pinocchio.buildModelFromXML(urdf)
    data, q = model.createData(), pinocchio.neutral(model)
    for name, position in positions.items():
        q[model.joints[model.getJointId(name)].idx_q] = position
    pinocchio.framesForwardKinematics(model, data, q)
    return {frame.name: place for frame, place in zip(model.frames, data.oMf, strict=True)}


@pytest.mark.parametrize(
    "urdf", [TURNED, robot_description(load_machine("loader"))], ids=["turned", "loader"]
)
def test_every_link_is_where_another_library_puts_it(urdf):
    joints = urdf_joints(urdf)
    rng = np.random.default_rng(4)
    positions = {joint.name: rng.uniform(-0.9, 0.9) for joint in joints if joint.kind != "fixed"}
    places = placed([*moving_frames(joints, positions), *fixed_frames(joints)])
    told = expected(urdf, positions)
    assert places.keys() == {joint.child for joint in joints}
    for name, place in places.items():
        np.testing.assert_allclose(place.homogeneous, told[name].homogeneous, atol=1e-12)


def test_a_joint_that_is_not_told_follows_its_leader():
    joints = urdf_joints(robot_description(load_machine("c180_hoses")))
    (rod,) = (joint for joint in joints if joint.name == "boom_cylinder_rod")
    frames = {frame.child: frame for frame in moving_frames(joints, {"boom": 0.5})}
    assert frames[rod.child].translation[0] == pytest.approx(rod.xyz[0] + rod.offset + 0.5 * rod.multiplier)


def test_a_text_that_is_no_urdf_is_one_sentence():
    with pytest.raises(ValueError, match="robot_description is no URDF"):
        urdf_joints("<robot")


def test_the_joints_that_are_published_are_those_of_the_urdf_and_of_the_table():
    for name in ("c180_hoses", "loader"):
        machine = load_machine(name)
        moving = {joint.name for joint in urdf_joints(robot_description(machine)) if joint.kind != "fixed"}
        assert set(joint_names(machine)) == moving
    assert joint_names(machine) == topics.VIEWER_JOINT_STATES.labels
    assert joint_names(machine)[-2:] == topics.HEAD_JOINTS


def test_a_foreign_reader_decodes_the_frames():
    frames = [Transform("a", f"link_{'x' * n}", (n, 2.0, 3.0), (0.0, 0.0, 0.6, 0.8)) for n in range(9)]
    schema = Schema(1, message_definition(topics.TF.type).encode(), "ros2msg", topics.TF.type)
    message = DecoderFactory().decoder_for("cdr", schema)(pack_transforms(3_000_000_007, frames))
    assert [told.child_frame_id for told in message.transforms] == [frame.child for frame in frames]
    for told, frame in zip(message.transforms, frames, strict=True):
        stamp, place, turn = told.header.stamp, told.transform.translation, told.transform.rotation
        assert (stamp.sec, stamp.nanosec, told.header.frame_id) == (3, 7, "a")
        assert (place.x, place.y, place.z) == frame.translation
        assert (turn.x, turn.y, turn.z, turn.w) == frame.rotation
