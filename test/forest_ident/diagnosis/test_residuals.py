"""Each residual against a number by hand: motion and pressures are made, not simulated."""

import math

import numpy as np
import pytest

from forest_description.derived.temperature import at_temperature
from forest_description.geometry.linkage import joint_angle
from forest_description.machine import load_machine
from forest_ident.diagnosis import residual_parameters
from forest_ident.diagnosis.monitor_readings import Learnt, Readings, Way
from forest_ident.diagnosis.residual_parameters import full_speed
from forest_ident.diagnosis.residuals import NAMES, Residuals, updated

MACHINE = load_machine("c180_hoses")
P = residual_parameters.parameters(MACHINE)
PERIOD = 0.005
BOOM, STICK = MACHINE.boom, MACHINE.stick
LENGTHS = 1.75, 2.1  # [m]
PORTS = (6e6, 6e6, 4e6, 4e6, 9e6, 9e6, 2e6, 2e6, 7e6, 7e6, 3e6, 3e6)  # [Pa]


def readings(boom=LENGTHS[0], stick=LENGTHS[1], swing=0.1, volts=(0.0, 0.0, 0.0), ports=PORTS, **others):
    angles = swing, joint_angle(boom, BOOM.linkage), joint_angle(stick, STICK.linkage)
    return Readings(voltages=volts, angles=angles, lengths=(boom, stick), pressures=tuple(ports), **others)


def over(seconds, at):
    """Return the mean of each residual's values over a made motion: time to readings."""
    found, state = {}, Residuals()
    for k in range(round(seconds / PERIOD)):
        state = updated(state, at(k * PERIOD), P, PERIOD)
        if state.ended:
            for name, z in zip(NAMES, state.values, strict=True):
                if not math.isnan(z):
                    found.setdefault(name, []).append(z)
    return {name: float(np.mean(values)) for name, values in found.items()}


def test_a_cylinder_that_sinks_under_constant_pressure_loses_oil_at_port_1():
    found = over(4.0, lambda t: readings(boom=LENGTHS[0] - 1e-3 * t))
    assert found["boom_lost_1"] == pytest.approx(-1e6 * BOOM.head_area * 1e-3, rel=1e-6)
    assert found["boom_lost_2"] == pytest.approx(1e6 * BOOM.rod_area * 1e-3, rel=1e-6)
    assert found["stick_lost_1"] == pytest.approx(0.0, abs=1e-6)


def test_oil_that_only_presses_other_oil_is_not_lost():
    line = MACHINE.line(1, 1)

    def rocking(t):
        way = 1e-4 * math.sin(8.0 * t)
        ports = np.array(PORTS)
        ports[4:6] -= BOOM.head_area * way / line.capacitance
        ports[6:8] += BOOM.rod_area * way / MACHINE.line(1, 2).capacitance
        return readings(boom=LENGTHS[0] + way, ports=ports)

    found = over(20.0, rocking)
    assert abs(found["boom_lost_1"]) < 1e-3
    assert found["boom_stiff_1"] == pytest.approx(0.0, abs=0.01)
    assert found["boom_stiff_2"] == pytest.approx(0.0, abs=0.01)


def test_oil_that_yields_twice_as_much_is_told_as_the_logarithm_of_two():
    line = MACHINE.line(1, 1)

    def rocking(t):
        way = 1e-4 * math.sin(8.0 * t)
        ports = np.array(PORTS)
        ports[4:6] -= 0.5 * BOOM.head_area * way / line.capacitance
        return readings(boom=LENGTHS[0] + way, ports=ports)

    assert over(20.0, rocking)["boom_stiff_1"] == pytest.approx(math.log(2.0), abs=0.01)


def test_pressure_that_moves_without_the_actuator_tells_no_stiffness():
    def pressed(t, way):
        ports = np.array(PORTS)
        ports[4:6] += 1e6 * math.sin(8.0 * t)
        return readings(boom=LENGTHS[0] + way, ports=ports)

    for way in (0.0, 1e-4):  # held by its friction; rocking for another reason
        assert "boom_stiff_1" not in over(20.0, lambda t, a=way: pressed(t, a * math.cos(8.0 * t)))


def test_motion_by_the_valves_law_is_followed_and_none_is_not():
    law, supply = P.axes[1].law, 20e6
    opening = (5.0 - law.forward.deadband_voltage) / (
        law.forward.rated_voltage - law.forward.deadband_voltage
    )
    speed = opening * math.sqrt((supply - PORTS[4]) / law.forward.resistance_1) / BOOM.head_area
    volts = 0.0, 5.0, 0.0
    right = over(4.0, lambda t: readings(boom=1.4 + speed * t, volts=volts, supply=supply))
    stuck = over(4.0, lambda t: readings(volts=volts, supply=supply))
    assert right["boom_follow"] < 0.02
    assert stuck["boom_follow"] == pytest.approx(1.0, abs=0.02)
    twice = Learnt(Way(law.forward.deadband_voltage, 2.0, 0.01, 0.01), Way())
    learnt = over(
        4.0,
        lambda t: readings(
            boom=1.4 + 2.0 * speed * t, volts=volts, supply=supply, valves=(Learnt(), twice, Learnt())
        ),
    )
    assert learnt["boom_follow"] < 0.02
    assert learnt["boom_gain_forward"] == pytest.approx(1.0)


def test_a_spool_is_told_by_how_many_milliseconds_it_is_late():
    late = 0.08

    def moving(t):
        volts = 3.0 * math.sin(2.0 * t)
        return readings(volts=(0.0, volts, 0.0), spools=(0.0, 3.0 * math.sin(2.0 * (t - late)), 0.0))

    lag = P.axes[1].lag  # the file's own does not count
    assert over(10.0, moving)["boom_spool"] == pytest.approx(1e3 * (late - lag), rel=0.1)


def test_only_what_the_driver_is_sure_of_counts():
    unsure = Learnt(Way(1.3, 1.1, 0.1, 0.01), Way(0.8, 0.9, 0.01, 0.01))
    found = over(4.0, lambda _: readings(valves=(unsure, Learnt(), Learnt())))
    assert "swing_deadband_forward" not in found
    assert found["swing_deadband_backward"] == pytest.approx(-0.2)
    assert found["swing_gain_backward"] == pytest.approx(-0.1)


def test_what_the_driver_learns_of_a_motor_in_hot_oil_does_not_count():
    """It takes a leakage for an overlap that it does not know of."""
    sure = Way(0.8, 0.9, 0.01, 0.01)
    learnt = (Learnt(sure, sure),) * 3

    def names(kelvin):
        def moving(t):
            around = {"supply": 2e7, "valves": learnt, "temperature": kelvin}
            return readings(boom=1.4 + 0.1 * t, swing=0.1 * t, volts=(0.0, 5.0, 0.0), **around)

        return set(over(4.0, moving))

    warm, hot = names(320.0), names(345.0)
    of_driver = "swing_follow", "swing_deadband_forward", "swing_deadband_backward", "swing_gain_forward"
    assert warm.issuperset(of_driver)
    assert hot.isdisjoint(of_driver)
    assert hot.issuperset(name.replace("swing", "boom") for name in of_driver)


def test_the_pumps_pressure_falls_with_the_flow_and_with_what_leaks():
    s = P.supply
    idle = s.set_pressure / (1.0 + s.leakage / s.compensation)
    found = over(4.0, lambda _: readings(supply=idle))
    assert found["supply"] == pytest.approx(0.0, abs=1e-6)
    hot = at_temperature(MACHINE, 350.0).pump.leakage_resistance
    thin = s.set_pressure / (1.0 + 1.0 / (hot * s.compensation))
    found = over(4.0, lambda _: readings(supply=thin, temperature=350.0))
    assert found["supply"] == pytest.approx(0.0, abs=1e-6)
    worn = over(4.0, lambda _: readings(supply=idle - 0.1e6))
    assert worn["supply"] == pytest.approx(-0.1, rel=0.02)


def test_sensors_that_tell_the_same_are_compared():
    ports = np.array(PORTS)
    ports[6] += 0.2e6

    def at(_):
        r = readings(ports=ports, case_drain=1e-5, temperature=280.0)
        return r._replace(lengths=(LENGTHS[0] + 4e-3, LENGTHS[1]))

    found = over(4.0, at)
    assert found["boom_agree"] == pytest.approx(4.0)
    assert found["stick_agree"] == pytest.approx(0.0, abs=1e-9)
    assert found["boom_pressure_2_pair"] == pytest.approx(0.2)
    assert found["boom_pressure_1_pair"] == pytest.approx(0.0)
    cold = at_temperature(MACHINE, 280.0).swing
    leaks = 10e6 / cold.external_leakage_resistance
    assert found["drain"] == pytest.approx(6e4 * (1e-5 - leaks))
    assert found["cold"] == pytest.approx(8.0)


def test_a_meter_is_told_by_the_logarithm_of_what_it_reads_too_much():
    speed = 0.2 * full_speed(P.axes[2])
    found = over(
        4.0,
        lambda t: readings(
            stick=2.0 + speed * t, volts=(0.0, 0.0, 5.0), flows=(0.0, 1.1 * STICK.head_area * speed)
        ),
    )
    assert found["stick_meter"] == pytest.approx(math.log(1.1), abs=1e-6)
    assert "swing_meter" not in found  # no flow


def test_oil_that_fills_a_port_while_it_moves_is_no_error_of_its_meter():
    top, rise, pace = 0.08 * full_speed(P.axes[2]), 4e6, 3.0  # [m/s], [Pa/s], [rad/s]

    def at(t):
        speed, way = top * (1.0 - math.cos(pace * t)), top * (t - math.sin(pace * t) / pace)
        ports = np.array(PORTS)
        ports[8:10] += rise * t
        flow = STICK.head_area * speed + MACHINE.line(2, 1).capacitance * rise
        return readings(stick=1.8 + way, volts=(0.0, 0.0, 5.0), ports=ports, flows=(0.0, 1.1 * flow))

    assert over(3.0, at)["stick_meter"] == pytest.approx(math.log(1.1), abs=0.003)
    blind = over(3.0, lambda t: at(t)._replace(pressures=(math.nan,) * 12))
    assert blind["stick_meter"] == pytest.approx(math.log(1.1), abs=0.2)  # it is judged, less exactly


@pytest.mark.parametrize("celsius", [-20.0, 40.0, 85.0])
def test_a_motor_that_leaks_as_its_file_says_at_the_oils_temperature_loses_nothing(celsius):
    kelvin = 273.15 + celsius
    motor, drop = at_temperature(MACHINE, kelvin).swing, PORTS[0] - PORTS[2]
    slips = drop / motor.internal_leakage_resistance + PORTS[0] / motor.external_leakage_resistance
    found = over(
        4.0,
        lambda t: readings(
            swing=-slips / (motor.motor_displacement * motor.gear_ratio) * t, temperature=kelvin
        ),
    )
    assert found["swing_lost_1"] == pytest.approx(0.0, abs=1e-6 * 1e6 * slips)
    rate = 0.3
    flow = motor.motor_displacement * motor.gear_ratio * rate + slips
    found = over(4.0, lambda t: readings(swing=rate * t, flows=(flow, 0.0), temperature=kelvin))
    assert found["swing_meter"] == pytest.approx(0.0, abs=1e-6)


def test_without_a_thermometer_oil_leaks_as_the_file_says():
    assert residual_parameters.thinned(P.oil, math.nan) == 1.0
    assert residual_parameters.thinned(residual_parameters.Viscosity(), 300.0) == 1.0
    broken = residual_parameters.thinned(P.oil, 3.0), residual_parameters.thinned(P.oil, 5000.0)
    assert 0.0 < broken[0] < 0.01
    assert 10.0 < broken[1] < 100.0


def test_a_port_behind_a_load_holding_valve_is_not_compared():
    numbers = residual_parameters.parameters(load_machine("c180"))
    assert (numbers.axes[1].one.is_open, numbers.axes[1].two.is_open) == (0, 1)


def test_residuals_without_their_sensors_are_silent():
    found = over(6.0, lambda t: Readings((0.0, 5.0, 0.0), (0.1, 0.3 + 0.01 * t, -1.2)))
    assert set(found) == set()
