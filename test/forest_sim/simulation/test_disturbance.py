"""Claims about what is done to a machine from outside."""

import math

import numpy as np
import pytest

from forest_description.derived.limits import pose_at, start_tip
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.disturbance import (
    GREATEST_FORCE,
    Disturbance,
    checked_tip_force,
    disturbed,
    parse_stuck_spools,
)
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium

C180 = load_machine("c180_hoses")
START = (0.0, 0.5, -1.5)


def after(p, voltages, seconds=1.0, start=None):
    start = equilibrium(START, p) if start is None else start
    return compiled_advance()(start, voltages, 1e-3, round(seconds * 1000), p)


def test_names_are_axes_and_anything_else_is_told_what_there_is():
    assert parse_stuck_spools(" boom, stick ") == ("boom", "stick")
    assert parse_stuck_spools("") == ()
    with pytest.raises(ValueError, match="no spool 'bucket'; allowed: swing, boom, stick"):
        parse_stuck_spools("boom bucket")


@pytest.mark.parametrize("axis", AXES)
def test_a_stuck_spool_stays_and_its_axis_with_it_while_the_others_move(axis):
    p = disturbed(plant_parameters(C180), Disturbance(stuck_spools=(axis,)))
    now = after(p, (4.0, 4.0, 4.0))
    moved = dict(zip(AXES, now.spools, strict=True))
    assert moved.pop(axis).position == 0.0
    assert all(spool.position > 3.9 for spool in moved.values())
    swung = now.plant.swing.angle
    assert (abs(swung) < 1e-3) == (axis == "swing")


@pytest.mark.parametrize("direction", range(3))
def test_a_force_on_the_tip_pushes_it_its_own_way(direction):
    force = [0.0, 0.0, 0.0]
    force[direction] = 5e3
    p = plant_parameters(C180)
    links = C180.manipulator.links
    q = disturbed(p, Disturbance(tip_force=tuple(force)))
    pushed = after(q, (0.0, 0.0, 0.0), 3.0, equilibrium(START, p)).plant
    left_alone = after(p, (0.0, 0.0, 0.0), 3.0).plant
    places = [tip_position(tuple(axis.angle for axis in plant[:3]), links) for plant in (pushed, left_alone)]
    assert np.subtract(*places)[direction] > 1e-4


def test_a_machine_that_starts_under_a_force_holds_it_with_its_trapped_oil():
    q = disturbed(plant_parameters(C180), Disturbance(tip_force=(4e3, 0.0, -6e3)))
    end = after(q, (0.0, 0.0, 0.0), 3.0).plant
    assert tuple(axis.angle for axis in end[:3]) == pytest.approx(START, abs=1e-9)


def test_no_disturbance_changes_nothing():
    p = plant_parameters(C180)
    assert after(disturbed(p, Disturbance()), (3.0, -2.0, 4.0)) == after(p, (3.0, -2.0, 4.0))


@pytest.mark.parametrize("force", [[1.0, 2.0], [0.0, math.nan, 0.0], [math.inf, 0.0, 0.0], [0.0, 0.0, 1e12]])
def test_a_force_that_no_machine_bears_is_refused_with_what_is_allowed(force):
    with pytest.raises(ValueError, match=r"allowed: 3 numbers in \+-200000 N"):
        checked_tip_force(force)


@pytest.mark.parametrize("name", ["c180", "c180_hoses", "forwarder", "loader"])
@pytest.mark.parametrize("place", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_the_greatest_force_leaves_every_state_finite(name, place, sign):
    machine = load_machine(name)
    force = [0.0, 0.0, 0.0]
    force[place] = sign * GREATEST_FORCE
    p = plant_parameters(machine)._replace(tip_force=checked_tip_force(force))
    now = compiled_advance()(
        equilibrium(pose_at(start_tip(machine), machine), p), (0.0, 0.0, 0.0), 1e-3, 100, p
    )
    assert all(np.all(np.isfinite(axis)) for axis in now.plant[:3])
