"""Claims about dry friction and cushions: their curves, and what they do to a cylinder."""

import dataclasses
import math

import numpy as np
import pytest
from full_machine import C180, CUSHION, FRICTION, START, advance

from forest_description.config.parameter import MachineError
from forest_description.geometry.linkage import cylinder_length, joint_angle
from forest_description.mechanics.drives import Friction
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.mechanics.end_stop import UNCUSHIONED, CushionBrake, cushion_resistance
from forest_sim.mechanics.friction import FRICTIONLESS, friction, friction_force, rubbing
from forest_sim.solver.equilibrium import equilibrium

LAW = friction(FRICTION)
BRAKE = CushionBrake(1.3, 2.2, CUSHION.length, CUSHION.resistance)


def test_at_speed_friction_is_coulombs_and_just_before_sliding_the_breakaway():
    assert friction_force(1.0, LAW) == pytest.approx(FRICTION.coulomb_force, rel=1e-5)
    smooth = dataclasses.replace(FRICTION, smoothing_speed=1e-6)
    assert friction_force(1e-4, friction(smooth)) == pytest.approx(FRICTION.breakaway_force, rel=1e-3)
    at_stribeck = FRICTION.coulomb_force + 3e3 * math.exp(-1.0)
    assert friction_force(0.02, friction(smooth)) == pytest.approx(at_stribeck, rel=1e-6)


def test_friction_opposes_the_motion_and_takes_energy_from_it():
    for speed in np.random.default_rng(1).normal(0.0, 0.1, 200):
        assert friction_force(speed, LAW) * speed > 0.0
        assert friction_force(-speed, LAW) == -friction_force(speed, LAW)
    assert friction_force(0.0, LAW) == 0.0


def test_friction_falls_with_the_stribeck_effect_and_never_under_coulombs():
    speeds = np.linspace(0.012, 0.06, 200)
    forces = [friction_force(speed, LAW) for speed in speeds]
    assert np.all(np.diff(forces) < 0.0)
    assert min(forces) > 0.99 * FRICTION.coulomb_force
    assert max(friction_force(u, LAW) for u in np.linspace(0.0, 1.0, 2000)) < FRICTION.breakaway_force


def test_slope_is_the_forces():
    h = 1e-7
    for speed in (0.0, *np.random.default_rng(2).normal(0.0, 0.03, 200).tolist()):
        slope = (friction_force(speed + h, LAW) - friction_force(speed - h, LAW)) / (2.0 * h)
        assert rubbing(speed, LAW).slope == pytest.approx(slope, rel=1e-5, abs=1.0)
    assert rubbing(0.015, LAW).slope < 0.0 < rubbing(0.0, LAW).slope


def test_no_friction_is_none():
    assert friction(None) == FRICTIONLESS
    for speed in (-1.0, 0.0, 1e-3):
        assert friction_force(speed, FRICTIONLESS) == rubbing(speed, FRICTIONLESS).slope == 0.0


def test_breaking_away_is_not_easier_than_sliding():
    with pytest.raises(MachineError, match=r"breakaway_force \(3000 N\) must not be below coulomb_force"):
        Friction(4e3, 3e3, 0.02, 1e-3)


def test_a_cushion_works_only_before_an_end_and_only_on_the_way_in():
    assert cushion_resistance(1.75, 1.0, BRAKE) == cushion_resistance(1.75, -1.0, BRAKE) == 0.0
    assert cushion_resistance(2.19, 1.0, BRAKE) > 0.0
    assert cushion_resistance(2.19, -1.0, BRAKE) == 0.0
    assert cushion_resistance(1.31, -1.0, BRAKE) > 0.0
    assert cushion_resistance(1.31, 1.0, BRAKE) == 0.0


def test_a_cushion_begins_without_a_step_and_is_whole_at_the_end_and_beyond():
    assert cushion_resistance(2.2 - CUSHION.length, 1.0, BRAKE) == pytest.approx(0.0, abs=1e-6)
    assert cushion_resistance(2.2 - 0.5 * CUSHION.length, 1.0, BRAKE) == pytest.approx(
        0.25 * CUSHION.resistance
    )
    for position in (2.2, 2.21):
        assert cushion_resistance(position, 1.0, BRAKE) == pytest.approx(CUSHION.resistance)
    assert cushion_resistance(2.3, 1.0, UNCUSHIONED) == 0.0


def with_boom(**parts):
    return dataclasses.replace(C180, boom=dataclasses.replace(C180.boom, **parts))


def near_upper_stop(distance):
    linkage = C180.boom.linkage
    return START[0], joint_angle(C180.boom.retracted_length + C180.boom.stroke - distance, linkage), START[2]


def impact_speed(machine):
    """Speed of the boom's piston at the first touch of its stop, extending with the valve open."""
    p = plant_parameters(machine)
    now, speed = equilibrium(near_upper_stop(0.15), p), 0.0
    for _ in range(4000):
        before, now = now, advance(now, (0.0, 5.0, 0.0), 1e-3, 1, p)
        position = cylinder_length(now.plant.boom.angle, p.boom_linkage)
        speed = (position - cylinder_length(before.plant.boom.angle, p.boom_linkage)) / 1e-3
        if position >= p.boom.stop.upper:
            return speed
    pytest.fail("the piston did not arrive")
    return speed


def test_a_cushion_brakes_the_piston_before_it_meets_the_stop():
    hard = dataclasses.replace(CUSHION, resistance=10.0 * CUSHION.resistance)
    speeds = [impact_speed(with_boom(cushion=cushion)) for cushion in (None, CUSHION, hard)]
    assert speeds[0] > 0.06
    assert speeds[1] < 0.85 * speeds[0]
    assert speeds[2] < 0.4 * speeds[0]


def test_a_cushion_does_not_hold_a_piston_that_leaves_the_end():
    ends = []
    for machine in (with_boom(), with_boom(cushion=CUSHION)):
        p = plant_parameters(machine)
        now = advance(equilibrium(near_upper_stop(0.01), p), (0.0, -5.0, 0.0), 1e-3, 400, p)
        ends.append(now.plant.boom.angle)
    assert ends[1] == pytest.approx(ends[0], abs=1e-12)
    assert START[1] < ends[1] < near_upper_stop(0.04)[1]


def test_friction_slows_a_cylinder():
    speeds = []
    for machine in (with_boom(), with_boom(friction=dataclasses.replace(FRICTION, coulomb_force=6.9e3))):
        p = plant_parameters(machine)
        speeds.append(advance(equilibrium(START, p), (0.0, 3.0, 0.0), 1e-3, 800, p).plant.boom.rate)
    assert 0.9 * speeds[0] < speeds[1] < 0.999 * speeds[0]


def test_dry_friction_ends_a_ringing_that_viscous_friction_only_dampens():
    """After a stop the boom rings on its oil for seconds; dry friction brings it to rest."""
    swings = []
    for machine in (with_boom(), with_boom(friction=FRICTION)):
        p = plant_parameters(machine)
        now = advance(equilibrium(START, p), (0.0, 3.0, 0.0), 1e-3, 600, p)
        now, rates = advance(now, (0.0, 0.0, 0.0), 1e-3, 2400, p), []
        for _ in range(400):
            now = advance(now, (0.0, 0.0, 0.0), 1e-3, 1, p)
            rates.append(abs(now.plant.boom.rate))
        swings.append(max(rates))
    assert swings[0] > 0.02
    assert swings[1] < 1e-4


def test_with_shut_valves_a_loaded_cylinder_with_friction_does_not_creep():
    """The oil carries the load, not the friction: smoothing its sign lets nothing sink in ten minutes."""
    p = plant_parameters(with_boom(friction=FRICTION))
    begin = equilibrium(START, p)
    end = advance(begin, (0.0, 0.0, 0.0), 0.1, 6000, p)
    sunk = cylinder_length(begin.plant.boom.angle, p.boom_linkage) - cylinder_length(
        end.plant.boom.angle, p.boom_linkage
    )
    assert abs(sunk) < 1e-9


def test_a_leaking_valve_lets_a_loaded_cylinder_creep_no_faster_than_its_leakage():
    """From head to tank at most leakage times the supply's pressure, over the piston's area."""
    leakage = 1e-13
    valve = dataclasses.replace(C180.valve, leakage_conductance=leakage)
    p = plant_parameters(with_boom(friction=FRICTION, valve=valve))
    begin = equilibrium(START, p)
    later = advance(begin, (0.0, 0.0, 0.0), 1e-2, 6000, p)
    travel = cylinder_length(later.plant.boom.angle, p.boom_linkage) - cylinder_length(
        begin.plant.boom.angle, p.boom_linkage
    )
    bound = 60.0 * 2.0 * leakage * p.supply.set_pressure / C180.boom.rod_area
    assert 0.0 < abs(travel) < bound + 2e-3  # and what the chambers' oil yields while they fill
