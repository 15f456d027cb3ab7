"""The load-moment limit: at the crane's capacity only motions that unload pass, and the limit is named."""

import dataclasses
import math

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.limits import load_moment
from forest_control.limits.load_moment import allowed_load
from forest_control.limits.velocity_scaling import Limit
from forest_control.operator.levers import Levers, levers_for_tip_velocity
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.simulation.load_schedule import Load, loaded
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
    assert told[-1].output.loading.utilisation > 1.05


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
    assert told[-1].output.loading.utilisation == 0.0
    assert told[-1].output.loading.mass == pytest.approx(HEAVY, rel=0.05)


def test_a_crane_whose_pressures_nobody_reads_counts_as_fully_loaded():
    told = driven(wished(OUT), mass=0.0, periods=300, blind=True)
    assert np.linalg.norm(way(told)) < 0.01
    assert told[-1].output.scaling.limit == Limit.LOAD
    assert way(driven(wished(IN), mass=0.0, periods=300, blind=True))[0] < -0.3
