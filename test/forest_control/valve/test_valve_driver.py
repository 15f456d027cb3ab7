"""Claims about the valve driver: with it, a real valve behaves like an ideal one."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from forest_control.valve import load_estimate, valve_driver, valve_driver_parameters, valve_hold
from forest_control.valve.load_estimate import STILL, UNSEEN, Pressures
from forest_control.valve.valve_driver import REST
from forest_control.valve.valve_driver_parameters import Settings
from forest_description.derived.actuator_kinematics import rated_speeds
from forest_description.hydraulics.valve_characteristic import (
    LINEAR_AREA,
    POLYNOMIAL,
    TABLE,
    Curve,
    Direction,
    ValveLaw,
    edges,
)
from forest_description.machine import load_machine

MACHINE = load_machine("c180_hoses")
VALVE = MACHINE.valve.law
SUPPLY = MACHINE.pump.supply_pressure
RATED = rated_speeds(MACHINE)
PERIOD = 0.005
ZERO_COMMAND = (0.0, 0.0, 0.0)
AXES = ["swing", "boom", "stick"]
every_axis = pytest.mark.parametrize("axis", range(3), ids=AXES)
both_directions = pytest.mark.parametrize("direction", [1.0, -1.0], ids=["positive", "negative"])


class Sides(NamedTuple):
    """Displacement of port 1 and port 2 [m^2; m^3/rad]."""

    one: float
    two: float


MOTOR = MACHINE.swing.gear_ratio * MACHINE.swing.motor_displacement
SIDES = [
    Sides(MOTOR, MOTOR),
    Sides(MACHINE.boom.head_area, MACHINE.boom.rod_area),
    Sides(MACHINE.stick.head_area, MACHINE.stick.rod_area),
]


def parameters(machine=MACHINE, **settings):
    """The driver of the valve alone: what lies beyond it is tested at the end."""
    return valve_driver_parameters.parameters(machine, Settings(**{"beyond_valve": False, **settings}))


def on_axis(axis, value):
    return tuple(value if i == axis else 0.0 for i in range(3))


def pressures(axis, load, supply=SUPPLY):
    """What the transducers say when the actuator of one axis carries a load [N; N m]."""
    base = 0.1 * supply
    return Pressures(
        on_axis(axis, base * SIDES[axis].two / SIDES[axis].one + max(load, 0.0) / SIDES[axis].one),
        on_axis(axis, base + max(-load, 0.0) / SIDES[axis].two),
        supply,
    )


def voltage(axis, command, measured=UNSEEN, p=None):
    _, volts = valve_driver.step(REST, on_axis(axis, command), measured, STILL, p or parameters(), PERIOD)
    assert all(volts[i] == 0.0 for i in range(3) if i != axis)
    return volts[axis]


def surplus(axis, speed, load, resistance, supply):
    """Force left over when an actuator moves at a speed through both orifices, along its speed."""
    one, two = SIDES[axis]
    if speed > 0.0:
        inlet, outlet = supply - resistance * (one * speed) ** 2, resistance * (two * speed) ** 2
        return one * inlet - two * outlet - load
    inlet, outlet = supply - resistance * (two * speed) ** 2, resistance * (one * speed) ** 2
    return two * inlet - one * outlet + load


def steady_speed(axis, volts, load=0.0, supply=SUPPLY):
    """Speed at which the pressures of the orifice law balance the load."""
    opened = edges(volts, VALVE)
    resistance = min(opened.supply_1, opened.supply_2)
    if math.isinf(resistance):
        return 0.0
    sign = math.copysign(1.0, volts)
    at_rest = surplus(axis, sign * 1e-12, load, resistance, supply)
    slope = at_rest - surplus(
        axis, sign, load, resistance, supply
    )  # the surplus falls with the speed's square
    return sign * math.sqrt(at_rest / slope)


def fastest(axis, direction, load, supply=SUPPLY):
    return abs(steady_speed(axis, direction * 10.0, load, supply))


@every_axis
@both_directions
@pytest.mark.parametrize("loaded", [False, True], ids=["unloaded", "loaded"])
def test_real_valve_gives_the_speed_that_the_ideal_one_was_asked_for(axis, direction, loaded):
    rng, p = np.random.default_rng(11), parameters()
    for _ in range(300):
        supply = SUPPLY * (rng.uniform(0.7, 1.1) if loaded else 1.0)
        load = rng.uniform(-0.6, 0.6) * min(SIDES[axis]) * supply if loaded else 0.0
        reach = min(10.0, 10.0 * fastest(axis, direction, load, supply) / RATED[axis])
        command = direction * rng.uniform(0.021, 0.9999 * reach)
        volts = voltage(axis, command, pressures(axis, load, supply), p)
        wished = RATED[axis] * command / 10.0
        assert steady_speed(axis, volts, load, supply) == pytest.approx(wished, rel=1e-9, abs=1e-12)


@every_axis
def test_deadband_inverse_cancels_the_valve_overlap(axis):
    for sign in (1.0, -1.0):
        assert abs(voltage(axis, sign * 0.0201)) > VALVE.forward.deadband_voltage
        assert math.copysign(1.0, voltage(axis, sign * 0.0201)) == sign
    assert voltage(axis, 5.0) == pytest.approx(1.0 + 9.0 * 0.5, rel=1e-12)
    assert voltage(axis, 10.0) == pytest.approx(10.0, rel=1e-12)


@every_axis
def test_a_load_against_the_motion_opens_the_valve_further_and_one_with_it_less(axis):
    load = 0.3 * min(SIDES[axis]) * SUPPLY
    for command in (3.0, -3.0):
        free = abs(voltage(axis, command, pressures(axis, 0.0)))
        against = abs(voltage(axis, command, pressures(axis, math.copysign(load, command))))
        along = abs(voltage(axis, command, pressures(axis, math.copysign(load, -command))))
        assert along < free < against


@pytest.mark.parametrize("command", [0.0, 0.02, -0.02, 1e-9])
def test_small_commands_leave_the_spool_centred(command):
    assert voltage(1, command) == 0.0


def test_the_hold_zone_is_as_wide_as_set():
    p = parameters(hold_zone=0.5)
    assert voltage(0, 0.5, p=p) == 0.0
    assert voltage(0, 0.5001, p=p) > 1.0


def test_without_compensation_commands_pass_unchanged():
    p, rng = parameters(compensate=False), np.random.default_rng(12)
    for command in map(tuple, rng.uniform(-10.0, 10.0, (100, 3)).tolist()):
        measured = pressures(1, 50e3)
        assert valve_driver.step(REST, command, measured, STILL, p, PERIOD)[1] == command
    assert voltage(0, 0.001, p=p) == 0.001
    assert voltage(0, 11.0, p=p) == 10.0
    assert voltage(0, -11.0, p=p) == -10.0


@every_axis
@both_directions
def test_voltage_stays_within_the_rating_under_every_load(axis, direction):
    rng, clipped = np.random.default_rng(13), 0
    for _ in range(300):
        load = rng.uniform(-1.5, 1.5) * max(SIDES[axis]) * SUPPLY
        volts = voltage(axis, direction * rng.uniform(5.0, 12.0), pressures(axis, load))
        assert 1.0 < direction * volts <= 10.0
        clipped += direction * volts == 10.0
    assert clipped > 50


@every_axis
def test_without_pressures_the_nominal_drop_is_assumed(axis):
    for command in (4.0, -4.0):
        state, volts = valve_driver.step(REST, on_axis(axis, command), UNSEEN, STILL, parameters(), PERIOD)
        assert not state.load.primed
        assert volts[axis] == voltage(axis, command, pressures(axis, 0.0))


def test_first_pressures_count_whole_and_later_ones_pass_the_low_pass():
    p, command = parameters(load_bandwidth=2.0), ZERO_COMMAND
    state, _ = valve_driver.step(REST, command, pressures(2, 50e3), STILL, p, PERIOD)
    assert state.load.loads == pytest.approx((0.0, 0.0, 50e3), abs=1e-6)
    for k in range(1, 101):
        state, _ = valve_driver.step(state, command, pressures(2, 90e3), STILL, p, PERIOD)
        expected = 90e3 - 40e3 * math.exp(-2.0 * math.pi * 2.0 * k * PERIOD)
        assert state.load.loads[2] == pytest.approx(expected, rel=1e-9)


@every_axis
@both_directions
def test_minimum_drop_bounds_the_compensation_under_an_overload(axis, direction):
    inlet = SIDES[axis].one if direction > 0.0 else SIDES[axis].two
    load = direction * 1.3 * inlet * SUPPLY
    command, p = direction * 1.0, parameters(minimum_drop=0.25)
    opening = (abs(voltage(axis, command, pressures(axis, load), p)) - 1.0) / 9.0
    free = (abs(voltage(axis, command, pressures(axis, 0.0), p)) - 1.0) / 9.0
    assert opening == pytest.approx(free / math.sqrt(0.25), rel=1e-12)


@pytest.mark.parametrize("supply", [5e-324, 1e3, 1e5, 1e308])
def test_a_supply_that_cannot_be_true_does_not_open_a_valve(supply):
    believed = voltage(0, 0.5)
    assert voltage(0, 0.5, pressures(0, 0.0, SUPPLY)._replace(supply=supply)) == believed


def test_a_weak_pump_does_not_open_a_valve_beyond_what_the_nominal_one_is_granted():
    """The least drop is a share of the nominal supply's force, not of what a failing pump still gives."""
    weak, p = 0.3 * SUPPLY, parameters(minimum_drop=0.25)
    load = 0.9 * SIDES[0].one * weak
    opening = (voltage(0, 1.0, pressures(0, load, weak), p) - 1.0) / 9.0
    free = (voltage(0, 1.0, pressures(0, 0.0), p) - 1.0) / 9.0
    assert opening == pytest.approx(free / math.sqrt(0.25), rel=1e-12)


def test_a_load_sensing_pump_at_rest_is_believed_and_one_that_is_off_is_not():
    loader = load_machine("loader")
    p = valve_driver_parameters.parameters(loader, Settings())
    idle = loader.pump.margin
    assert p.idle_pressure == idle < 0.25 * loader.pump.supply_pressure
    resting = Pressures((5e5,) * 3, (5e5,) * 3, idle)
    assert load_estimate.plausible(resting, p)
    assert load_estimate.plausible(resting._replace(supply=loader.pump.supply_pressure), p)
    assert not load_estimate.plausible(resting._replace(supply=0.1 * idle), p)


def test_without_pressures_a_load_sensing_pump_is_taken_to_be_at_rest():
    p = parameters(load_machine("loader"))
    resting = Pressures(ZERO_COMMAND, ZERO_COMMAND, p.idle_pressure)
    for axis in range(3):
        assert voltage(axis, 1.5, UNSEEN, p) == voltage(axis, 1.5, resting, p)


def random_machine(rng):
    """Another valve for every axis: two directions that differ, a straight, bent or tabulated curve."""
    curves = (None, "table", "polynomial")

    def law(curve):
        ways = [
            Direction(rng.uniform(0.0, 2.0), 10.0, *(10.0 ** rng.uniform(11.5, 12.5, 2)).tolist())
            for _ in range(2)
        ]
        if curve == "table":
            shape = Curve(TABLE, (0.0, 0.3, 0.6) + (1.0,) * 9, (0.0, 0.1, 0.5) + (1.0,) * 9)
        elif curve == "polynomial":
            shape = Curve(POLYNOMIAL, (0.0,) * 12, (100.0, -150.0, 51.0) + (0.0,) * 9)
        else:
            shape = LINEAR_AREA
        return ValveLaw(ways[0], ways[1], shape, 0.0)

    p = parameters()
    return p._replace(
        axes=tuple(
            axis._replace(valve=law(curve))
            for axis, curve in zip(p.axes, rng.permutation(curves), strict=True)
        )
    )


def test_the_inverse_is_exact_for_any_valve_under_any_load():
    rng, tried = np.random.default_rng(21), 0
    for _ in range(300):
        p, axis = random_machine(rng), int(rng.integers(3))
        a, supply = p.axes[axis], SUPPLY * rng.uniform(0.7, 1.1)
        load = rng.uniform(-0.6, 0.6) * min(SIDES[axis]) * supply
        command = math.copysign(rng.uniform(0.05, 6.0), rng.uniform(-1.0, 1.0))
        volts = voltage(axis, command, pressures(axis, load, supply), p)
        opened, speed = edges(volts, a.valve), a.rated_speed * command / 10.0
        c_1, c_2 = (opened.supply_1, opened.tank_2) if command > 0 else (opened.tank_1, opened.supply_2)
        drive = (SIDES[axis].one * supply - load) if command > 0 else (SIDES[axis].two * supply + load)
        edge = (a.valve.forward if command > 0 else a.valve.backward).deadband_voltage
        if edge + 1e-9 < abs(volts) < 10.0:  # a polynomial opens with a jump at the overlap's edge
            tried += 1
            reached = math.sqrt(drive / (c_1 * SIDES[axis].one ** 3 + c_2 * SIDES[axis].two ** 3))
            assert reached == pytest.approx(abs(speed), rel=1e-9)
    assert tried > 150


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_a_command_that_is_no_number_centres_its_valve(bad):
    state, volts = valve_driver.step(REST, (bad, 3.0, bad), UNSEEN, STILL, parameters(), PERIOD)
    assert volts[0] == volts[2] == 0.0
    assert volts[1] > 1.0
    state, volts = valve_driver.step(state, (1.0, 3.0, -1.0), UNSEEN, STILL, parameters(), PERIOD)
    assert volts[0] > 1.0
    assert volts[2] < -1.0


def test_dither_swings_about_the_voltage_and_leaves_a_shut_valve_alone():
    p, state, seen = parameters(dither_frequency=25.0), REST, []
    p = p._replace(axes=tuple(axis._replace(dither=0.2) for axis in p.axes))
    for _ in range(200):
        state, volts = valve_driver.step(state, (5.0, 0.0, 0.0), UNSEEN, STILL, p, PERIOD)
        assert volts[1:] == (0.0, 0.0)
        seen.append(volts[0] - 5.5)
    assert np.mean(seen) == pytest.approx(0.0, abs=1e-9)
    assert np.max(np.abs(seen)) == pytest.approx(0.2, abs=0.02)
    assert np.sum(np.diff(np.sign(np.round(seen, 9))) != 0) > 40


def test_a_valve_that_cannot_open_as_far_as_wished_says_so():
    p = parameters()
    state, _ = valve_driver.step(
        REST, (3.0, 9.0, -3.0), pressures(1, 0.5 * SIDES[1].one * SUPPLY), STILL, p, PERIOD
    )
    assert state.saturated == (False, True, False)


def test_noise_about_the_hold_zone_does_not_open_the_valve_again_and_again():
    p, rng, state, openings, shut = parameters(), np.random.default_rng(23), REST, 0, True
    for _ in range(4000):
        command = on_axis(1, 0.04 * rng.standard_normal())
        state, volts = valve_driver.step(state, command, UNSEEN, STILL, p, PERIOD)
        openings += shut and volts[1] != 0.0
        shut = volts[1] == 0.0
    assert openings <= 3


def test_an_actuator_that_is_held_comes_to_rest_at_once():
    p, hold = parameters(), valve_hold.SHUT
    for command in (*(2.0 for _ in range(20)), *(1e-9 for _ in range(12))):
        hold, command = valve_hold.held_command(
            hold, command, p.hold_zone, p.hold_zone, 0.0, 0.06, command < 1e-6, PERIOD
        )
    assert command == 0.0
    assert hold.calm_for >= valve_hold.CALM
    hold, command = valve_hold.held_command(hold, 0.03, p.hold_zone, p.hold_zone, 0.0, 0.06, False, PERIOD)
    assert command == 0.0  # at rest a small command has to last
