"""Claims about what the page draws: the URDF's tree and visuals, walls, reach, hoses, surroundings."""

import dataclasses
import json
import math
from xml.etree import ElementTree

import numpy as np
import pytest

from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import load_workspace, told
from forest_control.limits.workspace import clearance
from forest_description.derived.limits import joint_limits, workspace_limits
from forest_description.geometry.kinematics import tip_position
from forest_description.geometry.linkage import cylinder_length
from forest_description.machine import load_machine
from forest_description.mechanics.load import Log, Pendulum
from forest_description.types import AXES
from forest_description.urdf.robot_description import robot_description
from forest_msgs_py.interfaces import topics
from forest_station.scene.crane_signals import CRANE_JOINTS, crane_signals
from forest_station.scene.scene_description import scene_from_urdf, scene_of
from forest_station.scene.urdf_tree import SceneError, frames

NAMES = ("c180_hoses", "c180_thesis", "loader")
MACHINES = {name: load_machine(name) for name in NAMES}
EVERY = pytest.mark.parametrize("machine", MACHINES.values(), ids=NAMES)


def positions(machine, q):
    """Return joint positions as the signals tell them."""
    told = crane_signals(machine, dict(zip(AXES, q, strict=True)))
    return {name.removeprefix("crane/").removesuffix(".position"): value for name, value in told.items()}


def poses(machine, number=40):
    lower, upper = zip(*joint_limits(machine), strict=True)
    return np.random.default_rng(14).uniform(lower, upper, (number, 3)).tolist()


@EVERY
def test_tip_of_the_drawn_tree_is_the_tip_of_the_kinematics_at_random_poses(machine):
    joints = scene_of(machine)["joints"]
    for q in poses(machine):
        drawn = frames(joints, positions(machine, q))["tip"][:3, 3]
        np.testing.assert_allclose(drawn, tip_position(tuple(q), machine.manipulator.links), atol=1e-9)


@EVERY
def test_drawn_rods_reach_their_eyes_on_boom_and_stick(machine):
    joints = scene_of(machine)["joints"]
    for q in poses(machine, 10):
        found = frames(joints, positions(machine, q))
        for axis, drive, angle in (("boom", machine.boom, q[1]), ("stick", machine.stick, q[2])):
            eye = found[axis] @ [drive.pivot_to_rod, 0.0, 0.0, 1.0]
            np.testing.assert_allclose(found[f"{axis}_rod"][:3, 3], eye[:3], atol=1e-9)
            pivot = found[f"{axis}_barrel"][:3, 3]
            length = float(np.linalg.norm(eye[:3] - pivot))
            assert length == pytest.approx(cylinder_length(angle, drive.linkage), abs=1e-9)


@EVERY
def test_every_visual_of_the_urdf_is_drawn(machine):
    robot, scene = ElementTree.fromstring(robot_description(machine).encode()), scene_of(machine)
    assert set(scene["links"]) == {link.get("name") for link in robot.iter("link")}
    for link in robot.iter("link"):
        shapes = [next(iter(geometry)) for geometry in link.iter("geometry")]
        drawn = scene["links"][link.get("name")]
        assert [visual["shape"] for visual in drawn] == [shape.tag for shape in shapes]
        for visual, shape in zip(drawn, shapes, strict=True):
            assert visual["size"] == [float(n) for text in _sizes(shape) for n in text.split()]


def _sizes(shape):
    return [shape.get(key) for key in ("size", "radius", "length") if shape.get(key)]


def test_a_log_is_drawn_with_the_hanging_head():
    manipulator = dataclasses.replace(
        MACHINES["c180_hoses"].manipulator, pendulum=Pendulum(1.0, 50.0, 10.0), log=Log(500.0, 1.4, 0.0)
    )
    machine = dataclasses.replace(MACHINES["c180_hoses"], manipulator=manipulator)
    scene = scene_of(machine)
    assert [visual["shape"] for visual in scene["links"]["head"]] == ["sphere", "box", "cylinder"]
    assert {joint["name"] for joint in scene["joints"] if joint["signal"]} == {
        *CRANE_JOINTS,
        *topics.HEAD_JOINTS,
    }


@EVERY
def test_every_moving_joint_has_a_signal_that_somebody_tells(machine):
    rows = (topics.JOINT_STATES, topics.GROUND_TRUTH_HEAD)
    told = {
        *crane_signals(machine, {}),
        *(f"{row.name}/{joint}.position" for row in rows for joint in row.labels),
    }
    for joint in scene_of(machine)["joints"]:
        assert (joint["signal"] in told) == (joint["type"] != "fixed")


@EVERY
def test_signals_are_the_joints_themselves_and_nan_where_nobody_knows(machine):
    known = crane_signals(machine, {"swing": 0.1, "boom": 0.5})
    assert (known["crane/swing.position"], known["crane/boom.position"]) == (0.1, 0.5)
    assert math.isfinite(known["crane/boom_cylinder_rod.position"])
    unknown = {name for name, value in known.items() if math.isnan(value)}
    stick = {f"crane/{name}.position" for name in ("stick", "stick_cylinder_pivot", "stick_cylinder_rod")}
    assert unknown == stick


def test_walls_are_those_of_the_file_and_keep_the_tip_as_far():
    """The page's distance to a drawn wall is the controller's: the corners and faces agree."""
    workspace = load_workspace("c180")
    ground, cab, pillar = scene_of(MACHINES["c180_hoses"], workspace)["walls"]
    assert [wall["kind"] for wall in (ground, cab, pillar)] == ["plane", "box", "cylinder"]
    on_each = (
        (0.0, 0.0, ground["offset"]),
        tuple(cab["upper"]),
        (
            pillar["centre"][0] + pillar["radius"],
            pillar["centre"][1],
            0.5 * (pillar["bottom"] + pillar["top"]),
        ),
    )
    for point, wall in zip(on_each, workspace.walls, strict=False):
        assert clearance(point, wall).distance == pytest.approx(0.0, abs=1e-12)


def test_the_ground_stays_where_the_file_tells_it_whatever_margin_its_wall_keeps(tmp_path):
    path = tmp_path / "yard.yaml"
    path.write_text("ground: -1.5\nmargin: 0.2\n")
    machine, workspace = MACHINES["c180_hoses"], load_workspace(str(path))
    scene = scene_of(machine, workspace, told=told(str(path)))
    assert (scene["ground"], scene["walls"][0]["offset"]) == (-1.5, -1.3)
    path.write_text("stay_inside: {lower: [-9, -9, -1], upper: [9, 9, 5]}\n")  # its floor is no ground
    assert told(str(path)).ground is told("").ground is None
    walled = scene_of(machine, load_workspace(str(path)))
    assert walled["ground"] == scene_of(machine)["ground"]


def test_a_wall_is_called_as_its_file_calls_it_or_by_its_number(tmp_path):
    path = tmp_path / "yard.yaml"
    box = "lower: [1, 1, 1], upper: [2, 2, 2]"
    path.write_text(
        f"ground: -2\nboxes: [{{{box}, name: pile}}, {{{box}}}]\n"
        "cylinders: [{centre: [0, 3], radius: 0.5, lower: -1, upper: 1, name: post}]\n"
    )
    scene = scene_of(MACHINES["c180_hoses"], load_workspace(str(path)), told=told(str(path)))
    assert [wall["name"] for wall in scene["walls"]] == ["ground", "pile", "box 3", "post"]
    path.write_text(f"boxes: [{{{box}, name: 7}}]\n")
    for read in (load_workspace, told):
        with pytest.raises(SettingFileError, match="name is 7; allowed: a text of at most 30 characters"):
            read(str(path))


def test_slow_zone_is_where_the_fastest_tip_begins_to_brake():
    workspace = load_workspace("c180")
    scene = scene_of(MACHINES["c180_hoses"], workspace, tip_speed=0.8)
    assert scene["slow_zone"] == 0.8 / workspace.approach
    assert scene_of(MACHINES["c180_hoses"])["walls"] == []


@EVERY
def test_work_area_reaches_as_far_as_the_machine(machine):
    section = np.array(scene_of(machine)["work_area"]["section"])
    limits = workspace_limits(machine)
    assert section[:, 0].max() == pytest.approx(limits.reach_max, abs=0.02)
    assert section[:, 1].min() == pytest.approx(limits.height_min, abs=0.02)
    assert section[:, 1].max() == pytest.approx(limits.height_max, abs=0.02)
    assert scene_of(machine)["work_area"]["swing"] == list(joint_limits(machine)[0])


@EVERY
def test_no_pose_lies_outside_of_the_work_area(machine):
    outline = np.array(scene_of(machine)["work_area"]["section"])
    for _, boom, stick in poses(machine, 200):
        x, _, z = tip_position((0.0, boom, stick), machine.manipulator.links)
        assert _inside(x, z, outline) or _distance(x, z, outline) < 0.02


def _inside(x, z, outline):
    """Tell whether a ray to the right crosses the outline an odd number of times."""
    (a, b), (c, d) = outline.T, np.roll(outline, -1, axis=0).T
    crosses = (b > z) != (d > z)
    at = a + (c - a) * (z - b) / np.where(crosses, d - b, 1.0)
    return np.count_nonzero(crosses & (at > x)) % 2 == 1


def _distance(x, z, outline):
    start, along = outline, np.roll(outline, -1, axis=0) - outline
    share = np.clip(((np.array([x, z]) - start) * along).sum(1) / (along**2).sum(1), 0.0, 1.0)
    return np.linalg.norm(start + share[:, None] * along - [x, z], axis=1).min()


@EVERY
def test_radii_on_the_ground_lie_on_the_outline(machine):
    scene = scene_of(machine)
    outline = np.array(scene["work_area"]["section"])
    for radius in scene["work_area"]["ground"]:
        assert _distance(radius, scene["ground"], outline) < 1e-9


@EVERY
def test_hoses_go_from_a_valve_to_each_port_on_links_that_are_drawn(machine):
    scene = scene_of(machine)
    assert [hose["name"] for hose in scene["hoses"]] == [f"{axis}_{port}" for axis in AXES for port in (1, 2)]
    for hose in scene["hoses"]:
        links = [point["link"] for point in hose["points"]]
        assert links[0] == "platform"
        assert links[-1] == (
            "platform" if hose["name"].startswith("swing") else f"{hose['name'][:-2]}_barrel"
        )
        assert set(links) <= set(scene["links"])
    first, second = scene["hoses"][:2]
    for out, back in zip(first["flow"], second["flow"], strict=True):
        assert (out["signal"], out["factor"]) == (back["signal"], -back["factor"])


@EVERY
def test_trees_stand_out_of_reach_and_the_bunk_within(machine):
    scene = scene_of(machine)
    reach = workspace_limits(machine).reach_max
    things = {thing["kind"]: thing for thing in scene["surroundings"]}
    assert set(things) == {"carrier", "bunk", "tree"}
    assert math.hypot(*things["bunk"]["xyz"][:2]) < reach
    for thing in scene["surroundings"]:
        assert thing["xyz"][2] == scene["ground"]
        if thing["kind"] == "tree":
            assert math.hypot(*thing["xyz"][:2]) - thing["size"][0] > reach


@EVERY
def test_a_scene_is_json_and_the_recorded_description_gives_the_same_but_for_the_load_chart(machine):
    scene = scene_of(machine)
    assert json.loads(json.dumps(scene, allow_nan=False)) == scene
    assert scene_from_urdf(robot_description(machine)) == scene | {"capacity": []}
    chart = machine.capacity
    assert scene["capacity"] == (
        [list(point) for point in zip(chart.reach, chart.load, strict=True)] if chart else []
    )


ALONE = "<robot><link name='base_link'/></robot>"
CIRCLE = "<robot><link name='b'/><joint name='j'><parent link='b'/><child link='b'/></joint></robot>"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("no XML", "allowed: a URDF text"),
        ("<model/>", "its root is <model>; allowed: <robot>"),
        (ALONE, "no joint 'swing' with limits"),
        (CIRCLE, "joint 'j' hangs from 'b'"),
    ],
)
def test_what_cannot_be_drawn_is_told_in_a_sentence(text, said):
    with pytest.raises(SceneError, match=said):
        scene_from_urdf(text)


def test_what_the_page_cannot_draw_is_left_out_and_fixed_turns_count():
    """Of another's robot description: a mesh has no place here, an origin may be turned."""
    text = robot_description(MACHINES["c180_hoses"])
    mesh = "<visual><geometry><mesh filename='x.stl'/></geometry></visual><visual/>"
    turned = text.replace('<link name="tip" />', f'<link name="tip">{mesh}</link>').replace(
        'rpy="0.0 0.0 0.0"', 'rpy="0.0 0.0 1.5707963267948966"', 1
    )
    assert turned.count("mesh") == 1
    assert scene_from_urdf(turned)["links"]["tip"] == []
    scene = scene_of(MACHINES["c180_hoses"])
    scene["joints"][0]["rpy"] = [0.0, 0.0, math.pi / 2]
    ahead, left = (
        frames(joints, {})["tip"][:3, 3]
        for joints in (scene_of(MACHINES["c180_hoses"])["joints"], scene["joints"])
    )
    np.testing.assert_allclose(left, [-ahead[1], ahead[0], ahead[2]], atol=1e-12)
