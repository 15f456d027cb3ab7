"""Claims about the URDF, read back with an own small forward kinematics."""

import dataclasses
from xml.etree import ElementTree

import numpy as np
import pytest

from forest_description.kinematics import tip_position
from forest_description.limits import joint_limits
from forest_description.machine import load_machine
from forest_description.urdf import robot_description

MACHINE = load_machine()
ROBOT = ElementTree.fromstring(robot_description(MACHINE))


def numbers(element, name):
    return np.array([float(text) for text in element.get(name).split()])


def transform(rotation, translation):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, translation
    return matrix


def turn(axis, angle):
    """Rotation matrix about a unit axis (Rodrigues)."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def frame(robot, link, angles):
    """Pose of a link in base_link, walking up through the joints."""
    joint = next((j for j in robot.findall("joint") if j.find("child").get("link") == link), None)
    if joint is None:
        return np.eye(4)
    origin = joint.find("origin")
    assert not numbers(origin, "rpy").any()
    moved = np.eye(3)
    if joint.get("type") == "revolute":
        moved = turn(numbers(joint.find("axis"), "xyz"), angles[joint.get("name")])
    parent = frame(robot, joint.find("parent").get("link"), angles)
    return parent @ transform(moved, numbers(origin, "xyz"))


def test_tip_of_the_urdf_is_the_tip_of_the_kinematics_at_random_poses():
    for q in np.random.default_rng(6).uniform(-3.0, 3.0, (100, 3)).tolist():
        angles = dict(zip(("swing", "boom", "stick"), q, strict=True))
        expected = tip_position(tuple(q), MACHINE.manipulator.links)
        np.testing.assert_allclose(frame(ROBOT, "tip", angles)[:3, 3], expected, atol=1e-12)


def test_links_hang_together_in_one_tree_from_base_link():
    links = [link.get("name") for link in ROBOT.findall("link")]
    children = [joint.find("child").get("link") for joint in ROBOT.findall("joint")]
    assert links == ["base_link", "platform", "boom", "stick", "head", "tip"]
    assert sorted([*children, "base_link"]) == sorted(links)


def test_moving_joints_have_the_names_and_limits_of_the_machine():
    moving = [joint for joint in ROBOT.findall("joint") if joint.get("type") == "revolute"]
    assert [joint.get("name") for joint in moving] == ["swing", "boom", "stick"]
    for joint, interval in zip(moving, joint_limits(MACHINE), strict=True):
        limit = joint.find("limit")
        assert (float(limit.get("lower")), float(limit.get("upper"))) == interval
        assert float(limit.get("effort")) > 1e4
        assert 0.2 < float(limit.get("velocity")) < 5.0


def test_masses_and_their_moments_about_the_pivots_are_those_of_the_thesis():
    angles = {"swing": 0.0, "boom": 0.4, "stick": -1.3}
    part = MACHINE.manipulator
    c2, s2, c23, s23 = np.cos(0.4), np.sin(0.4), np.cos(-0.9), np.sin(-0.9)
    centre_mass = part.stick_mass * part.stick_x + part.head_mass * part.stick_length
    expected = part.boom_mass * (part.boom_x * c2 - part.boom_y * s2) + (
        (part.stick_mass + part.head_mass) * part.boom_length * c2
        + centre_mass * c23
        - part.stick_mass * part.stick_y * s23
    )
    moment = 0.0  # of the weights about the boom pivot, over g: G2 of Appendix B
    for name in ("boom", "stick", "head"):
        inertial = next(link for link in ROBOT.findall("link") if link.get("name") == name).find("inertial")
        centre = frame(ROBOT, name, angles) @ [*numbers(inertial.find("origin"), "xyz"), 1.0]
        moment += float(inertial.find("mass").get("value")) * (centre[0] - part.base_offset)
    assert moment == pytest.approx(expected, rel=1e-12)


def test_inertias_about_the_joint_axis_and_across_are_those_of_the_thesis():
    moments = {link.get("name"): link.find("inertial/inertia") for link in ROBOT.findall("link")}
    part = MACHINE.manipulator
    for name, about_joint, across in (
        ("boom", part.boom_zz, part.boom_yy),
        ("stick", part.stick_zz, part.stick_yy),
    ):
        assert float(moments[name].get("iyy")) == about_joint
        assert float(moments[name].get("izz")) == across
    assert float(moments["platform"].get("izz")) == part.base_zz


def test_every_inertia_could_belong_to_a_body():
    inertials = [link.find("inertial") for link in ROBOT.findall("link") if link.find("inertial") is not None]
    assert len(inertials) == 4
    for inertial in inertials:
        ixx, iyy, izz = sorted(float(inertial.find("inertia").get(key)) for key in ("ixx", "iyy", "izz"))
        assert ixx > 0.0
        assert izz <= (ixx + iyy) * (1.0 + 1e-12)


def test_a_name_with_special_characters_stays_readable():
    odd = dataclasses.replace(MACHINE, name='crane "A" & <B>')
    assert ElementTree.fromstring(robot_description(odd)).get("name") == 'crane "A" & <B>'
