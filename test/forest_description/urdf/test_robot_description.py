"""Claims about the URDF, read back with an own small forward kinematics."""

import dataclasses
from xml.etree import ElementTree

import numpy as np
import pytest

from forest_description.derived.bodies import boom_body, stick_body
from forest_description.derived.limits import joint_limits
from forest_description.derived.passive_joints import (
    CYLINDER_JOINTS,
    HEAD_JOINTS,
    cylinder_joint_positions,
    head_joint_positions,
)
from forest_description.geometry.kinematics import tip_position
from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_description.mechanics.load import Log, Pendulum
from forest_description.urdf.robot_description import robot_description

MACHINE, THESIS, LOADER = load_machine("c180_hoses"), load_machine("c180_thesis"), load_machine("loader")
EVERY = pytest.mark.parametrize("machine", [MACHINE, THESIS, LOADER], ids=["c180_hoses", "thesis", "loader"])
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
    moved, place = np.eye(3), numbers(origin, "xyz")
    if joint.get("type") == "revolute":
        moved = turn(numbers(joint.find("axis"), "xyz"), angles[joint.get("name")])
    if joint.get("type") == "prismatic":
        place = place + numbers(joint.find("axis"), "xyz") * angles[joint.get("name")]
    parent = frame(robot, joint.find("parent").get("link"), angles)
    return parent @ transform(moved, place)


def inertial(robot, name):
    """Return mass, centre of mass and inertia tensor of a link in its own frame, None for a massless one."""
    element = next(link for link in robot.findall("link") if link.get("name") == name).find("inertial")
    if element is None:
        return None
    i = {key: float(value) for key, value in element.find("inertia").items()}
    tensor = [[i["ixx"], i["ixy"], i["ixz"]], [i["ixy"], i["iyy"], i["iyz"]], [i["ixz"], i["iyz"], i["izz"]]]
    return float(element.find("mass").get("value")), numbers(element.find("origin"), "xyz"), np.array(tensor)


def with_manipulator(**changes):
    return dataclasses.replace(MACHINE, manipulator=dataclasses.replace(MACHINE.manipulator, **changes))


def test_tip_of_the_urdf_is_the_tip_of_the_kinematics_at_random_poses():
    for q in np.random.default_rng(6).uniform(-3.0, 3.0, (100, 3)).tolist():
        angles = dict(zip(("swing", "boom", "stick"), q, strict=True))
        expected = tip_position(tuple(q), MACHINE.manipulator.links)
        np.testing.assert_allclose(frame(ROBOT, "tip", angles)[:3, 3], expected, atol=1e-12)


def test_links_hang_together_in_one_tree_from_base_link():
    links = [link.get("name") for link in ROBOT.findall("link")]
    children = [joint.find("child").get("link") for joint in ROBOT.findall("joint")]
    drawn = ["boom_barrel", "boom_rod", "stick_barrel", "stick_rod"]
    assert links == ["base_link", "platform", "boom", "stick", "head", "tip", *drawn]
    assert sorted([*children, "base_link"]) == sorted(links)


def test_moving_joints_have_the_names_and_limits_of_the_machine():
    moving = [joint for joint in ROBOT.findall("joint") if joint.get("type") == "revolute"][:3]
    assert [joint.get("name") for joint in moving] == ["swing", "boom", "stick"]
    for joint, interval in zip(moving, joint_limits(MACHINE), strict=True):
        limit = joint.find("limit")
        assert (float(limit.get("lower")), float(limit.get("upper"))) == interval
        assert float(limit.get("effort")) > 1e4
        assert 0.2 < float(limit.get("velocity")) < 5.0


def test_no_joint_but_those_of_the_cylinders_is_left_to_others():
    """Of a machine without a hanging head: a viewer that knows swing, boom and stick has all positions."""
    moving = [joint for joint in ROBOT.findall("joint") if joint.get("type") != "fixed"]
    told = ("swing", "boom", "stick")
    assert {joint.get("name") for joint in moving} == {*told, *CYLINDER_JOINTS}
    for joint in moving[3:]:
        assert joint.find("mimic").get("joint") in told
        assert joint.get("name").startswith(joint.find("mimic").get("joint"))


@EVERY
def test_masses_and_inertias_are_those_of_the_dynamics(machine):
    robot, parts = ElementTree.fromstring(robot_description(machine)), machine.manipulator
    for name, body in (("boom", boom_body(parts)), ("stick", stick_body(parts))):
        mass, centre, tensor = inertial(robot, name)
        assert (mass, *centre) == (body.mass, body.x, 0.0, body.y)
        expected = [[body.xx, 0.0, -body.xy], [0.0, body.zz, 0.0], [-body.xy, 0.0, body.yy]]
        np.testing.assert_array_equal(tensor, expected)
    mass, centre, tensor = inertial(robot, "platform")
    assert (mass, *centre, tensor[2, 2]) == (parts.base_mass, parts.base_x, 0.0, 0.0, parts.base_zz)


def test_only_the_three_bodies_of_the_dynamics_weigh():
    heavy = [link.get("name") for link in ROBOT.findall("link") if link.find("inertial") is not None]
    assert heavy == ["platform", "boom", "stick"]


def test_weights_about_the_boom_pivot_are_those_of_the_thesis():
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
    for name in ("boom", "stick"):
        mass, centre, _ = inertial(ROBOT, name)
        moment += mass * ((frame(ROBOT, name, angles) @ [*centre, 1.0])[0] - part.base_offset)
    assert moment == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    "machine",
    [MACHINE, with_manipulator(log=Log(mass=900.0, x=0.4, y=-0.3)), LOADER],
    ids=["c180_hoses", "c180_hoses with log", "loader"],
)
def test_every_inertia_could_belong_to_a_body(machine):
    """The second moments of mass along the principal axes are not negative; not so Appendix B's."""
    robot = ElementTree.fromstring(robot_description(machine))
    for name in ("platform", "boom", "stick"):
        principal = np.linalg.eigvalsh(inertial(robot, name)[2])
        assert min(0.5 * principal.sum() - principal) > -1e-9 * principal.max()


@EVERY
def test_rods_eyes_lie_on_the_driven_links_over_the_whole_stroke(machine):
    robot = ElementTree.fromstring(robot_description(machine))
    _, boom, stick = joint_limits(machine)
    for share in np.linspace(0.0, 1.0, 21).tolist():
        q = (0.3, boom[0] + share * (boom[1] - boom[0]), stick[0] + share * (stick[1] - stick[0]))
        positions = cylinder_joint_positions(q, machine)
        angles = dict(zip(("swing", "boom", "stick", *CYLINDER_JOINTS), (*q, *positions), strict=True))
        for name, drive, angle in (("boom", machine.boom, q[1]), ("stick", machine.stick, q[2])):
            eye, barrel = (frame(robot, f"{name}_{part}", angles)[:3, 3] for part in ("rod", "barrel"))
            pin = frame(robot, name, angles) @ [drive.pivot_to_rod, 0.0, 0.0, 1.0]
            np.testing.assert_allclose(eye, pin[:3], atol=1e-12)
            assert np.linalg.norm(eye - barrel) == pytest.approx(cylinder_length(angle, drive.linkage))


@EVERY
def test_cylinders_that_only_follow_their_joint_stay_near_their_place_and_inside_their_limits(machine):
    robot = ElementTree.fromstring(robot_description(machine))
    _, boom, stick = joint_limits(machine)
    joints = {joint.get("name"): joint for joint in robot.findall("joint")}
    for share in np.linspace(0.0, 1.0, 21).tolist():
        q = (0.0, boom[0] + share * (boom[1] - boom[0]), stick[0] + share * (stick[1] - stick[0]))
        angles = dict(zip(("swing", "boom", "stick"), q, strict=True))
        for name, exact in zip(CYLINDER_JOINTS, cylinder_joint_positions(q, machine), strict=True):
            rule, limit = joints[name].find("mimic"), joints[name].find("limit")
            angles[name] = (
                float(rule.get("offset")) + float(rule.get("multiplier")) * angles[rule.get("joint")]
            )
            for position in (angles[name], exact):
                assert float(limit.get("lower")) - 1e-3 <= position <= float(limit.get("upper")) + 1e-3
        for name, drive in (("boom", machine.boom), ("stick", machine.stick)):
            pin = frame(robot, name, angles) @ [drive.pivot_to_rod, 0.0, 0.0, 1.0]
            assert np.linalg.norm(frame(robot, f"{name}_rod", angles)[:3, 3] - pin[:3]) < 0.17


def test_a_hanging_head_stands_as_its_angles_tell():
    machine = with_manipulator(pendulum=Pendulum(0.9, 60.0, 250.0), log=Log(500.0, 1.4, 0.0))
    robot = ElementTree.fromstring(robot_description(machine))
    mass, centre, tensor = inertial(robot, "head")
    assert mass == machine.manipulator.head_mass + 500.0
    np.testing.assert_array_equal(tensor, np.diag([tensor[0, 0], tensor[0, 0], 0.0]))
    for q, alpha, beta in (((0.0, 0.5, -1.4), 0.3, -0.2), ((0.0, 1.1, -2.0), -0.4, 0.6)):
        names = ("swing", "boom", "stick", *HEAD_JOINTS)
        angles = dict(zip(names, (*q, *head_joint_positions(q, (alpha, beta))), strict=True))
        along = frame(robot, "head", angles)[:3, :3] @ centre / np.linalg.norm(centre)
        d = (np.sin(alpha) * np.cos(beta), np.sin(beta), -np.cos(alpha) * np.cos(beta))
        np.testing.assert_allclose(along, d, atol=1e-12)
        expected = tip_position(q, machine.manipulator.links)
        np.testing.assert_allclose(frame(robot, "head", angles)[:3, 3], expected, atol=1e-12)


def test_a_log_is_drawn_where_its_centre_is():
    robot = ElementTree.fromstring(robot_description(with_manipulator(log=Log(900.0, 0.4, -0.3))))
    head = next(link for link in robot.findall("link") if link.get("name") == "head")
    np.testing.assert_array_equal(numbers(head.findall("visual")[1].find("origin"), "xyz"), [0.4, 0.0, -0.3])


def test_a_name_with_special_characters_stays_readable():
    odd = dataclasses.replace(MACHINE, name='crane "A" & <B>')
    assert ElementTree.fromstring(robot_description(odd)).get("name") == 'crane "A" & <B>'


def test_beams_and_head_are_drawn_in_the_machine_s_own_size():
    sizes = {}
    for machine in (MACHINE, LOADER):
        robot, parts = ElementTree.fromstring(robot_description(machine)), machine.manipulator
        boom = robot.find("link[@name='boom']/visual/geometry/box")
        sizes[machine.name] = numbers(boom, "size")[1]
        assert numbers(boom, "size")[0] == parts.boom_length
        head = robot.find("link[@name='head']/visual/geometry/sphere")
        assert float(head.get("radius")) < 0.1 * parts.stick_length
    assert sizes["loader"] == pytest.approx(sizes["c180_hoses"] * 2.25 / 4.118356)


@EVERY
def test_every_visual_has_a_colour_that_the_description_tells(machine):
    robot = ElementTree.fromstring(robot_description(machine))
    told = {one.get("name"): numbers(one.find("color"), "rgba") for one in robot.findall("material")}
    assert all(((rgba >= 0.0) & (rgba <= 1.0)).all() and rgba[3] == 1.0 for rgba in told.values())
    used = {visual.find("material").get("name") for visual in robot.iter("visual")}
    assert {"paint", "cast", "barrel", "rod"} <= used <= set(told)


def test_a_bar_reaches_from_the_tip_to_a_head_that_hangs():
    robot = ElementTree.fromstring(robot_description(load_machine("c180")))
    ball, bar = robot.findall("link[@name='head']/visual")
    middle, size = numbers(bar.find("origin"), "xyz"), numbers(bar.find("geometry/box"), "size")
    assert middle[2] + 0.5 * size[2] == 0.0
    assert middle[2] - 0.5 * size[2] == numbers(ball.find("origin"), "xyz")[2]
