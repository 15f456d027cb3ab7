"""What the page draws of load, bending and what holds the crane back: its parts, without pixels."""

import math
from typing import Any

import numpy as np
import pytest
from page_stand_in import Js

from forest_control.config.workspace_file import load_workspace
from forest_control.limits.velocity_scaling import Limit
from forest_description.derived.limits import joint_limits, pose_at, start_tip
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_station.scene.crane_signals import crane_signals
from forest_station.scene.greatest_rates import GreatestRates
from forest_station.scene.scene_description import scene_of

C180 = load_machine("c180")
SCENE = scene_of(C180, load_workspace("c180"))
Q = pose_at(start_tip(C180), C180)
LOADED = ["boom_barrel", "boom_rod", "log"]
DRAW = """async (m, [scene, values, trouble]) => {
  const { Signals } = await import("/web/scene/signals.js");
  const signals = new Signals(Object.keys(values));
  signals.show(1, Float64Array.from(Object.values(values)));
  const picture = (globalThis.picture ??= new m.Picture(scene));
  picture.limits.trouble = trouble;
  const labels = picture.pose(signals).map(({ key, text, at }) => [key, { text, at: at.toArray() }]);
  const { crane, loadLimit } = picture;
  return {
    labels: Object.fromEntries(labels),
    glowing: [...crane.materials].filter(([, { emissive }]) => emissive.r > 0).map(([name]) => name).sort(),
    log: crane.log.root.visible ? crane.log.root.scale.toArray() : null,
    tip: picture.tip().toArray(),
    arc: loadLimit.arc.line.visible,
    rigid: picture.bending.line.line.visible,
  };
}"""


def drawn(js: Js, values: dict[str, float], trouble: str = "") -> dict[str, Any]:
    """Return what is drawn of the standing crane, with further signals told."""
    angles = dict(zip(AXES, Q, strict=True))
    joints = {f"joint_states/{axis}.position": angle for axis, angle in angles.items()}
    told: dict[str, Any] = js(
        "scene/picture.js", DRAW, [SCENE, joints | crane_signals(C180, angles) | values, trouble]
    )
    return told


def loaded(mass: float, share: float) -> dict[str, float]:
    """Return the signals of a load that is weighed."""
    return {"tip/load/mass": mass, "tip/load/share": share}


def moving(stick: float) -> dict[str, float]:
    """Return the signals of joints that move, the stick at a rate [rad/s]."""
    told = dict(zip((f"{axis}.velocity" for axis in AXES), (-0.1, 0.03, stick), strict=True))
    told |= dict(zip((f"{axis}.position" for axis in AXES), Q, strict=True))
    return {f"joint_states/{name}": value for name, value in told.items()} | GreatestRates(C180).signals(told)


@pytest.mark.parametrize(
    ("limit", "others", "glowing", "named"),
    [
        (Limit.RATE, {}, [], "speed limit of a joint or valve"),
        (Limit.RATE, moving(0.05), [], "speed limit of a joint or valve"),
        (Limit.RATE, moving(-0.19), ["stick"], "stick: greatest speed"),
        (
            Limit.JOINT,
            {"joint_states/boom.position": joint_limits(C180)[1][0]},
            ["boom"],
            "boom: joint limit",
        ),
        (Limit.SINGULARITY, {}, [], "singular pose"),
        (Limit.FLOW, {}, ["platform"], "pump flow: no more to give"),
        (Limit.WALL, {}, [], "wall: ground"),
        (Limit.LOAD, loaded(900.0, 0.95), LOADED, "load: 95 % of what is allowed here"),
        (Limit.OVERLOAD, {}, ["log"], "overload: let go of the deadman, then put the load down"),
        (Limit.LATE, {}, [], "late link: slower"),
    ],
    ids=lambda value: value.name if isinstance(value, Limit) else "",
)
def test_what_holds_the_tip_back_lights_up_where_it_acts_and_has_a_name(
    js: Js, limit: Limit, others: dict[str, float], glowing: list[str], named: str
) -> None:
    found = drawn(js, others | {"controller/status/limit": limit})
    assert found["glowing"] == glowing
    assert found["labels"]["limit"]["text"] == named


def test_that_the_deadman_is_released_is_no_label_of_the_live_crane_for_a_line_at_the_top_tells_it(
    js: Js,
) -> None:
    assert "limit" not in drawn(js, {"controller/status/limit": Limit.RELEASED})["labels"]


def test_a_valve_that_cannot_open_further_lights_its_cylinder(js: Js) -> None:
    found = drawn(js, {"valve_driver/status/stick_saturated": 1.0})
    assert found["glowing"] == ["stick_barrel", "stick_rod"]
    assert found["labels"]["stick_saturated"]["text"] == "stick: valve fully open"


def test_the_joint_that_the_controllers_trouble_is_about_lights_up_and_says_it(js: Js) -> None:
    found = drawn(js, {}, "overload: stick went back by 0.021 rad in 0.30 s; allowed: put the load down")
    assert found["glowing"] == ["stick"]
    assert found["labels"]["trouble"]["text"] == "overload: stick went back by 0.021 rad in 0.30 s"
    assert drawn(js, {}, "no state of the machine")["glowing"] == []


def test_links_are_drawn_ahead_of_their_joints_by_what_they_bend(js: Js) -> None:
    bent = (0.01, -0.02, 0.015)
    found = drawn(js, {f"ground_truth/deflections/{axis}": by for axis, by in zip(AXES, bent, strict=True)})
    links = C180.manipulator.links
    angles = tuple(np.add(Q, bent))
    np.testing.assert_allclose(found["tip"], tip_position(angles, links), atol=1e-6)
    way = math.dist(tip_position(angles, links), tip_position(Q, links))
    assert found["labels"]["bending"]["text"] == f"bent by {100 * way:.0f} cm"
    assert found["rigid"]
    still = drawn(js, {})
    np.testing.assert_allclose(still["tip"], tip_position(Q, links), atol=1e-6)
    assert not still["rigid"]
    assert "bending" not in still["labels"]


@pytest.mark.parametrize(
    ("told", "size"),
    [
        ({"ground_truth/load/mass": 500.0, "ground_truth/load/length": 5.0}, (500.0, 5.0)),
        (loaded(500.0, 0.5), (500.0, 4.0)),
        ({"ground_truth/load/mass": 0.0, "ground_truth/load/length": 4.0} | loaded(500.0, 0.5), None),
        (loaded(10.0, 0.01), None),
        ({}, None),
    ],
    ids=["told", "weighed", "none though weighed", "too light", "unknown"],
)
def test_the_log_is_as_long_and_as_thick_as_its_mass_makes_it(
    js: Js, told: dict[str, float], size: tuple[float, float] | None
) -> None:
    log = drawn(js, told)["log"]
    if size is None:
        assert log is None
        return
    mass, length = size
    radius = math.sqrt(mass / (math.pi * length * 850.0))  # green spruce
    assert log == pytest.approx([radius, radius, length])


def test_the_load_that_hangs_shows_how_far_out_it_may_go(js: Js) -> None:
    assert C180.capacity is not None
    reaches, loads = C180.capacity.reach, C180.capacity.load
    for mass in np.linspace(loads[-1] + 1.0, loads[0] - 1.0, 9).tolist():
        found = drawn(js, loaded(mass, 0.6))
        reach = float(np.interp(-mass, np.negative(loads), reaches))
        assert found["labels"]["load"]["text"] == f"{mass:.0f} kg: up to {reach:.1f} m"
        x, y, _ = found["labels"]["load"]["at"]
        assert math.hypot(x, y) == pytest.approx(reach)
        assert found["arc"]
    for mass, share in ((loads[-1] - 1.0, 0.6), (loads[0], 0.1), (math.nan, math.nan)):
        assert not drawn(js, loaded(mass, share))["arc"]
