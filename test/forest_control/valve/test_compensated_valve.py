"""Claims about valves with compensators: what the driver opens, what is learnt, how fast an axis may go."""

import math
from dataclasses import replace

import pytest

from forest_control.limits.actuator_speed_limits import joint_rate_limits, speed_limit_parameters
from forest_control.valve.load_estimate import Motion, Pressures
from forest_control.valve.tracking_limit import OpeningRatio
from forest_control.valve.valve_adaptation import DirectionEstimate, gain
from forest_control.valve.valve_driver import REST, step
from forest_control.valve.valve_driver_parameters import Settings, parameters
from forest_control.valve.valve_inverse import required_opening
from forest_description.derived.actuator_kinematics import displacements, metering_drop, rated_speeds
from forest_description.geometry.linkage import lever_arm
from forest_description.hydraulics.compensator_parameters import CompensatorBeforeSpool
from forest_description.hydraulics.valve_characteristic import opening_at, stroke
from forest_description.machine import load_machine

FORWARDER = load_machine("forwarder")
P = parameters(FORWARDER, Settings())
UNHELD = parameters(
    replace(
        FORWARDER,
        boom=replace(FORWARDER.boom, holding_1=None),
        stick=replace(FORWARDER.stick, holding_1=None, holding_2=None),
    ),
    Settings(),
)
FULL = OpeningRatio((1.0, 1.0, 1.0), (1.0, 1.0, 1.0))


def test_what_a_compensator_leaves_the_spools_edge():
    """Behind the spool it is the pump's margin less its own; before it, its setting; half open."""
    assert metering_drop(FORWARDER, 1) == pytest.approx(2.4e6 - 0.4e6 - 0.3e6)
    before = CompensatorBeforeSpool(
        setting=1e6, control_range=4e5, minimum_resistance=5e10, response_time=0.015
    )
    machine = replace(FORWARDER, valve=replace(FORWARDER.valve, compensator=before))
    assert metering_drop(machine, 1) == pytest.approx(0.8e6)
    assert metering_drop(load_machine("c180_hoses"), 1) == math.inf


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_the_driver_opens_for_the_inlets_flow_whatever_the_load(axis, direction):
    """Its opening lets the actuator's flow through port 1's edge, or port 2's, at the kept drop."""
    driver, law = P.axes[axis], FORWARDER.valve_of(axis).law
    way, port = (law.forward, 0) if direction > 0.0 else (law.backward, 1)
    edge = (way.resistance_1, way.resistance_2)[port]
    flow = 0.3 * math.sqrt(metering_drop(FORWARDER, axis) / edge)
    speed = direction * flow / displacements(FORWARDER, axis)[port]
    for share in (0.0, 0.4, 0.8):
        load = direction * share * displacements(FORWARDER, axis)[port] * P.supply_pressure
        opening = required_opening(speed, load, P.supply_pressure, 0.0, driver, P)
        assert opening == pytest.approx(direction * 0.3, rel=1e-12)


def test_the_scale_of_commands_is_the_kept_drop_up_to_the_pumps_flow():
    speeds, pump = rated_speeds(FORWARDER), FORWARDER.pump.flow_limit
    for axis, speed in enumerate(speeds):
        area = displacements(FORWARDER, axis)[0]
        kept = math.sqrt(metering_drop(FORWARDER, axis) / FORWARDER.valve_of(axis).law.forward.resistance_1)
        assert speed == pytest.approx(min(kept, pump) / area)


def test_no_axis_is_told_to_go_faster_than_its_compensator_lets_it():
    c = speed_limit_parameters(FORWARDER, P.axes)
    q = (0.0, 0.5, -1.4)
    for sign in (1.0, -1.0):
        limits = joint_rate_limits(q, (sign, sign, sign), c, FULL)
        for axis, linkage in ((1, FORWARDER.boom.linkage), (2, FORWARDER.stick.linkage)):
            arm = lever_arm(q[axis], linkage)
            law = FORWARDER.valve_of(axis).law
            extends = arm * sign > 0.0
            edge = law.forward.resistance_1 if extends else law.backward.resistance_2
            area = displacements(FORWARDER, axis)[0 if extends else 1]
            most = math.sqrt(metering_drop(FORWARDER, axis) / edge) / area
            assert limits[axis] * abs(arm) < most


@pytest.mark.parametrize("direction", [1.0, -1.0])
@pytest.mark.parametrize("load", [0.2, 0.6])
def test_a_gain_is_learnt_from_the_inlets_flow_whatever_the_load(direction, load):
    """A spool that stands open, an actuator at seven tenths of the speed by the file."""
    state = REST
    supply = P.idle_pressure + load * P.supply_pressure
    inlet = [0.0, 0.0, 0.0]
    for k in range(800):
        volts = direction * (4.0 + math.sin(0.02 * k))
        for i, axis in enumerate(P.axes):
            law, area = axis.valve, displacements(FORWARDER, i)[0 if direction > 0.0 else 1]
            way = law.forward if direction > 0.0 else law.backward
            edge = way.resistance_1 if direction > 0.0 else way.resistance_2
            opening = opening_at(stroke(abs(state.strokes[i]), way), law.curve)
            inlet[i] += 0.7 * 0.005 * direction * opening * math.sqrt(axis.metering_drop / edge) / area
        at = tuple(axis.middle + gone for axis, gone in zip(P.axes, inlet, strict=True))
        one, two = (load, 0.01) if direction > 0.0 else (0.01, load)
        pressures = Pressures((one * P.supply_pressure,) * 3, (two * P.supply_pressure,) * 3, supply)
        motion = Motion(at, pressures.port_1, pressures.port_2)
        commands = tuple(_command(volts, axis) for axis in P.axes)
        state, _ = step(state, commands, pressures, motion, UNHELD, 0.005)
    for one in state.estimates:
        way = one.forward if direction > 0.0 else one.backward
        assert gain(way) == pytest.approx(0.7, abs=0.07)
        other = one.backward if direction > 0.0 else one.forward
        assert other == DirectionEstimate()


def _command(volts, axis):
    """Return a command that brings a spool to about so many volts [V]."""
    return math.copysign(max(0.1, abs(volts) - 2.0), volts)


def test_nothing_is_learnt_where_the_pump_leaves_less_than_the_kept_drop():
    state = REST
    supply = P.idle_pressure
    for k in range(200):
        at = tuple(axis.middle + 0.1 * axis.rated_speed * 0.005 * k for axis in P.axes)
        pressures = Pressures((0.5 * supply,) * 3, (0.5 * supply,) * 3, supply)
        state, _ = step(state, (5.0, 5.0, 5.0), pressures, Motion(at, *pressures[:2]), P, 0.005)
    assert all(one.forward == DirectionEstimate() for one in state.estimates)


def test_a_machine_without_compensators_has_the_bits_it_had():
    c180_hoses = load_machine("c180_hoses")
    driver = parameters(c180_hoses, Settings())
    assert [axis.metering_drop for axis in driver.axes] == [math.inf] * 3
