"""Each candidate is a machine that can be written, and that simulates otherwise than the crane without it."""

import dataclasses
import math

import pytest

from forest_description.machine import load_machine
from forest_ident.model_choice.candidates import CANDIDATES, NAMES, added

CRANES = ("c180_hoses", "loader", "forwarder")


@pytest.mark.parametrize("name", CRANES)
def test_every_candidate_can_be_added_to_every_crane(name):
    machine = load_machine(name)
    for candidate in CANDIDATES:
        richer = candidate.add(machine)
        assert candidate.add(richer) == richer, candidate.name


def test_a_crane_that_has_the_physics_stays_as_it_is():
    forwarder = load_machine("forwarder")
    same = {candidate.name for candidate in CANDIDATES if candidate.add(forwarder) == forwarder}
    assert same == set(NAMES) - {"curve"}


def test_a_plain_crane_is_changed_by_every_candidate():
    plain = load_machine("c180_hoses")
    assert all(candidate.add(plain) != plain for candidate in CANDIDATES)


def richer(name):
    plain = load_machine("c180_hoses")
    (candidate,) = (one for one in CANDIDATES if one.name == name)
    return plain, candidate.add(plain)


def numbers(part):
    return dataclasses.astuple(part)


def test_dry_friction_is_of_the_seals_area_and_of_the_motors_torque():
    plain, crane = richer("friction")
    for axis in ("boom", "stick"):
        force = 1.5e5 * getattr(plain, axis).head_area
        assert numbers(getattr(crane, axis).friction)[:4] == pytest.approx((force, 1.5 * force, 0.012, 0.002))
    torque = 0.03 * plain.swing.gear_ratio * plain.swing.motor_displacement * plain.pump.supply_pressure
    ring = crane.swing.friction
    assert (ring.coulomb_torque, ring.breakaway_torque) == pytest.approx((torque, 1.5 * torque))
    assert (ring.stiffness / torque, ring.damping / torque) == pytest.approx((1e4, 50.0))
    assert (ring.stribeck_speed, ring.elastic_share) == (0.01, 0.8)


def test_play_is_half_a_millimetre_and_a_motors_inertia_grows_as_its_volume():
    plain, crane = richer("backlash")
    torque = plain.swing.gear_ratio * plain.swing.motor_displacement * plain.pump.supply_pressure
    play = crane.swing.backlash
    assert numbers(play)[::2] == pytest.approx((1.5e-3, 1e3 * torque))
    assert numbers(play)[3] == pytest.approx(0.4 * torque)
    size = plain.swing.motor_displacement / (45e-6 / (2.0 * math.pi))  # of 45 cm3 a turn
    assert numbers(play)[1] == pytest.approx(0.0024 * size ** (5.0 / 3.0), rel=1e-3)


def test_dead_volumes_are_a_share_of_what_is_swept_and_the_oil_has_usual_air():
    plain, crane = richer("chambers")
    for axis in ("boom", "stick"):
        drive = getattr(plain, axis)
        swept = [0.03 * area * drive.stroke for area in (drive.head_area, drive.rod_area)]
        assert numbers(getattr(crane, axis).chambers) == pytest.approx(tuple(swept))
    assert numbers(crane.swing.chambers) == pytest.approx((14.0 * plain.swing.motor_displacement,))
    assert crane.oil is None or numbers(crane.oil.air) == pytest.approx((0.005, 3e6, 101325.0, 100.0))


def test_valves_get_play_dead_time_stroke_time_leak_and_notches_of_usual_size():
    plain, crane = richer("hysteresis")
    rated, late = plain.valve.rated_voltage, crane.valve
    assert (late.hysteresis, late.dead_time) == pytest.approx((0.04 * rated, 0.008))
    assert late.spool_slew_limit == pytest.approx(25.0 * rated)  # through its stroke in 40 ms
    plain, crane = richer("leakage")
    assert crane.valve.leakage_conductance * plain.pump.supply_pressure == pytest.approx(8.3e-8)
    _, crane = richer("curve")
    volts, openings = numbers(crane.valve.curve)
    back = plain.valve.backward or plain.valve
    edge = max(plain.valve.deadband_voltage, back.deadband_voltage)
    strokes = [(volt - edge) / (rated - edge) for volt in volts]
    assert strokes == pytest.approx([0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0])
    assert openings == pytest.approx([1e-3 * stroke**1.5 for stroke in strokes])


def test_load_holding_is_set_above_the_pump_and_throttles_less_than_the_valve():
    plain, crane = richer("holding")
    edge = plain.valve.minimum_resistance
    usual = (1.3 * plain.pump.supply_pressure, 3.0, 1e6, 5e6, edge / 7.0, edge / 20.0, 0.01)
    held = [crane.boom.holding_1, crane.stick.holding_1, crane.stick.holding_2]
    for valve in held:
        told = (valve.setting, valve.pilot_ratio, valve.hysteresis, valve.opening_range)
        assert (*told, valve.minimum_resistance, valve.check_resistance, valve.response_time) == usual
    assert crane.boom.holding_2 is None
    assert crane.stick.chambers is not None


def test_links_bend_by_8_mrad_under_the_outstretched_cranes_weight():
    plain, crane = richer("bending")
    m = plain.manipulator
    weights = [(m.boom_mass, abs(m.boom_x)), (m.stick_mass, m.boom_length + abs(m.stick_x))]
    weights.append((m.head_mass, m.boom_length + m.stick_length))
    boom = sum(mass * m.gravity * lever for mass, lever in weights)
    stick = boom - m.gravity * (m.boom_mass * abs(m.boom_x) + (m.stick_mass + m.head_mass) * m.boom_length)
    for axis, torque in (("swing", boom), ("boom", boom), ("stick", stick)):
        link = getattr(crane, axis).elasticity
        assert link.stiffness * 0.008 == pytest.approx(torque)
        assert (link.damping / link.stiffness, link.root_inertia) == pytest.approx((1e-3, 50.0))


def test_a_head_hangs_as_a_body_of_a_tenth_of_its_radius_squared():
    plain, crane = richer("pendulum")
    inertia = 0.1 * plain.manipulator.head_mass * 0.81
    body = crane.manipulator.pendulum
    assert (body.length, body.inertia, body.damping) == pytest.approx((0.9, inertia, 3.3 * inertia))


def test_an_axis_without_its_own_record_gets_no_friction_and_is_named():
    plain, crane = richer("friction")
    (friction,) = (one for one in CANDIDATES if one.name == "friction")
    assert added(friction, plain, ["damping_swing", "damping_boom", "damping_stick"]) == (crane, [])
    some, untold = added(friction, plain, ["damping_boom", "valve"])
    assert untold == ["swing", "stick"]
    assert (some.boom, some.swing, some.stick) == (crane.boom, plain.swing, plain.stick)
    (bending,) = (one for one in CANDIDATES if one.name == "bending")
    assert added(bending, plain, []) == (bending.add(plain), [])
