"""The load-moment limit: at the crane's capacity only motions that unload pass, and the limit is named."""

import dataclasses
import math

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.limits import load_moment
from forest_control.limits.load_moment import (
    Loading,
    allowed_load,
    allowed_speed,
    believed_mass,
    loading,
    unloaded,
)
from forest_control.limits.velocity_scaling import Limit
from forest_control.operator.levers import Levers, levers_for_tip_velocity
from forest_control.pipeline.control_state import REST
from forest_control.pipeline.controller import counted_angles
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.simulation.load import Load, loaded
from forest_study.closed_loop.closed_loop import ClosedLoop, Operator

REAL, C180 = load_machine("c180"), load_machine("c180_hoses")
HEAVY, TIP = 1300.0, (6.5, 0.0, -1.0)  # 1.13 of what is allowed there
OUT, UP, DOWN, IN, ASIDE = (
    (0.5, 0.0, 0.0),
    (0.0, 0.0, 0.5),
    (0.0, 0.0, -0.5),
    (-0.5, 0.0, 0.0),
    (0.0, 0.5, 0.0),
)


def driven(levers, mass=HEAVY, tip=TIP, machine=REAL, scheme=Scheme.COORDINATED, periods=500, blind=False):
    """The telemetry of a crane that is driven from 0.5 s on, period by period."""
    plant = loaded(plant_parameters(machine), machine.manipulator, Load(mass))
    control = controller_settings.parameters(machine, controller_settings.Settings(scheme=scheme))
    drive = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings())
    suite = sensor_suite(
        dataclasses.replace(machine, sensors=dataclasses.replace(machine.sensors, pressure=None))
        if blind
        else machine,
        noise=True,
        seed=5,
    )
    loop = ClosedLoop(plant, control, drive, pose_at(tip, machine), suite, fast=True)
    told = []
    for k in range(periods):
        loop.period(Operator(levers if k >= 100 else Levers(0.0, 0.0, 0.0)))
        told.append(loop.telemetry)
    return told


def wished(velocity):
    return levers_for_tip_velocity(velocity, 0.5)


def way(told):
    """How far the tip has gone [m] since 0.5 s, outward, aside and up."""
    return np.array(told[-1].tip) - np.array(told[99].tip)


@pytest.mark.parametrize("velocity", [OUT, UP])
def test_a_crane_that_carries_too_much_moves_neither_outward_nor_up_and_says_why(velocity):
    told = driven(wished(velocity))
    assert np.linalg.norm(way(told)) < 0.01
    assert all(one.output.scaling.limit == Limit.LOAD for one in told[105:])
    assert told[-1].output.scaling.factor < 0.1  # sliding aside: a heading is never exact
    assert told[-1].output.loading.share > 1.05


@pytest.mark.parametrize("velocity", [DOWN, IN])
def test_it_moves_down_and_inward_as_ever(velocity):
    told = driven(wished(velocity), periods=400)
    # 1.5 s, less the ramp and what the oil takes to begin.
    assert way(told) @ np.array(velocity) / 0.5 > 0.5 * 1.5 - 0.15
    assert all(one.output.scaling.limit != Limit.LOAD for one in told[101:])


def test_of_a_wish_outward_and_down_it_goes_down_and_slewing_keeps_its_reach():
    down = way(driven(wished((0.35, 0.0, -0.35))))
    assert abs(down[0]) < 0.03
    assert down[2] < -0.5
    slewn = driven(wished(ASIDE))
    assert math.hypot(*slewn[-1].tip[:2]) < math.hypot(*slewn[99].tip[:2]) + 0.02
    assert way(slewn)[1] > 0.6


def test_the_joint_scheme_has_the_same_limit():
    raised, slewn = (
        driven(levers, scheme=Scheme.JOINT) for levers in (Levers(0.0, 0.3, 0.0), Levers(0.3, 0.0, 0.0))
    )
    assert np.linalg.norm(way(raised)) < 0.03
    assert raised[-1].output.scaling.limit == Limit.LOAD
    assert way(slewn)[1] > 0.5


def test_outward_the_tip_comes_to_rest_before_its_load_is_more_than_allowed():
    told = driven(wished(OUT), mass=1250.0, tip=(4.8, 0.0, 0.5), periods=1800)
    reach = [math.hypot(*one.tip[:2]) for one in told]
    assert abs(reach[-1] - reach[-200]) < 0.02
    assert reach[-1] > reach[0] + 0.5
    true = [1250.0 / allowed_load(one, load_moment.capacity(REAL)) for one in reach]
    assert max(true) < 1.05
    assert told[-1].output.scaling.limit == Limit.LOAD


def test_a_machine_without_capacity_has_no_such_limit():
    assert C180.capacity is None
    told = driven(wished(OUT), machine=C180, periods=300)
    assert way(told)[0] > 0.3
    assert told[-1].output.loading.share == 0.0
    assert told[-1].output.loading.mass == pytest.approx(HEAVY, rel=0.05)


def test_a_crane_whose_pressures_nobody_reads_counts_as_fully_loaded():
    told = driven(wished(OUT), mass=0.0, periods=300, blind=True)
    assert np.linalg.norm(way(told)) < 0.01
    assert told[-1].output.scaling.limit == Limit.LOAD
    assert way(driven(wished(IN), mass=0.0, periods=300, blind=True))[0] < -0.3


def test_the_chart_is_straight_between_its_points():
    c = load_moment.capacity(REAL)
    reaches, loads = REAL.capacity.reach, REAL.capacity.load
    for reach in np.linspace(0.0, 10.0, 101):
        assert allowed_load(float(reach), c) == pytest.approx(np.interp(reach, reaches, loads))
    assert allowed_load(8.0, load_moment.capacity(C180)) == math.inf


def test_whatever_is_wished_no_more_loads_than_may_and_what_does_not_load_is_untouched():
    rng = np.random.default_rng(7)
    for _ in range(5000):
        p, v = tuple(rng.uniform(-7.0, 7.0, 3)), tuple(rng.uniform(-1.0, 1.0, 3))
        load = Loading(1000.0, math.hypot(p[0], p[1]), 1000.0, float(rng.uniform(0.5, 1.2)))
        most = allowed_speed(load)
        before = np.array(parts(p, v))
        asked = before[0] + max(0.0, before[2])
        slid, left = unloaded(p, v, load, keeps_path=False)
        kept, share = unloaded(p, v, load, keeps_path=True)
        if asked <= most:
            assert (slid, kept, left, share) == (v, v, 1.0, 1.0)
            continue
        for after in (np.array(parts(p, slid)), np.array(parts(p, kept))):
            assert after[0] + max(0.0, after[2]) == pytest.approx(most, abs=1e-9)
        assert parts(p, slid)[1] == pytest.approx(before[1])
        assert kept == pytest.approx(share * np.array(v))
        assert 0.0 <= left <= 1.0


def parts(p, v):
    """A velocity outward, aside and up."""
    r = math.hypot(p[0], p[1])
    return (p[0] * v[0] + p[1] * v[1]) / r, (p[0] * v[1] - p[1] * v[0]) / r, v[2]


def test_what_is_not_weighed_counts_as_all_that_is_allowed():
    c, q = load_moment.capacity(REAL), pose_at(TIP, REAL)
    links = REAL.manipulator.links
    assert loading(math.nan, q, links, c).share == 1.0
    loader = load_machine("loader")
    near = pose_at((loader.manipulator.links.base_offset + 0.7, 0.0, -1.9), loader)
    told = loading(math.nan, near, loader.manipulator.links, load_moment.capacity(loader))
    assert told.share == 0.0  # or the crane could not get away from where nothing can be weighed
    assert loading(-50.0, q, links, c).share == 0.0
    told = loading(575.0, q, links, c)
    assert told.reach == pytest.approx(math.hypot(*tip_position(q, links)[:2]))
    assert told.share == pytest.approx(0.5)
    assert allowed_speed(told) == pytest.approx(told.reach)
    assert allowed_speed(told._replace(share=1.3)) == 0.0
    assert unloaded(TIP, ZERO, told._replace(share=1.3), keeps_path=False)[0] == ZERO


def test_a_mass_that_no_crane_can_carry_is_not_believed():
    machine = load_machine("c180")
    p = controller_settings.parameters(machine, controller_settings.Settings())
    head, allowed = 700.0, 1150.0  # [kg] of the file; the latter from 6 m on
    q = pose_at((7.5, 0.0, 0.0), machine)

    def believed(mass, chart=p.capacity):
        return believed_mass(mass, head, q, p.links, chart)

    assert believed(5000.0) == 1.25 * allowed
    assert [believed(mass) for mass in (-700.0, 0.0, allowed)] == [-700.0, 0.0, allowed]
    assert believed(-2000.0) == -700.0
    assert math.isnan(believed(math.nan))
    assert believed(5000.0, load_moment.NO_CAPACITY) == 5000.0

    def tip(mass):
        state = REST._replace(weighing=REST.weighing._replace(mass=mass))
        return tip_position(counted_angles(q, state, p), p.links)

    assert math.dist(tip(0.0), tip(5000.0)) < 0.05  # 0.13 m if it were
