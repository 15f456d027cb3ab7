"""Claims about inertial units: exact at rest, misled by accelerations as their filter lets them through."""

import dataclasses
import math

import numpy as np
import pytest

from forest_description.geometry.kinematics import Links, tip_position
from forest_description.machine import load_machine
from forest_description.sensors.sensor_kinds import InertialUnit
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors import sensor_readings
from forest_sim.sensors.inertial_unit import filtered
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_model import SensorMemory, sample
from forest_sim.sensors.sensor_suite import Draws, draw, noise_generator, sensor_suite
from forest_sim.solver.equilibrium import equilibrium

UNIT = InertialUnit(
    boom_distance=2.0,
    stick_distance=1.5,
    time_constant=0.5,
    accuracy=None,
    gyro_bias=None,
    gyro_noise=None,
    accelerometer_noise=None,
)
C180 = load_machine("c180_hoses")
LINKS, G = C180.manipulator.links, C180.manipulator.gravity
Q = (0.3, 0.5, -1.5)
DT = 0.005


def fitted(**changes):
    """The crane with inertial units in the place of boom's and stick's resolvers."""
    unit = dataclasses.replace(UNIT, **changes)
    sensors = dataclasses.replace(C180.sensors, inertial_unit=unit, joint_angles="inertial_unit")
    return dataclasses.replace(C180, sensors=sensors)


P = plant_parameters(C180)
REST = equilibrium(Q, P)


def moved(angles, rates):
    """The crane in a pose that moves at joint rates [rad/s]."""
    plant = REST.plant
    axes = {
        name: getattr(plant, name)._replace(angle=angle, rate=rate)
        for name, angle, rate in zip(("swing", "boom", "stick"), angles, rates, strict=True)
    }
    return REST._replace(plant=plant._replace(**axes))


def followed(motion, count, machine=None, noise=True, seed=0, faults="", dt=DT):
    """What a suite says of a motion (time -> angles, rates), sample by sample; seed 0: nothing is drawn."""
    suite = sensor_suite(machine or fitted(), noise, seed, parse_faults(faults))
    generator = noise_generator(suite)
    state, said = sensor_readings.at_rest(moved(*motion(0.0)), P, suite), []
    for i in range(1, count + 1):
        given = draw(generator) if seed else Draws([0.0] * len(suite.channels), [0.0] * len(suite.channels))
        at = moved(*motion(i * dt))
        state, seen = sensor_readings.measure(at, state, P, dt, suite, given)
        said.append(seen)
    return said


def standing(_time):
    return Q, (0.0, 0.0, 0.0)


def errors(said, motion, dt=DT):
    """Boom's and stick's angles read less the true ones [rad]."""
    true = [motion((i + 1) * dt)[0] for i in range(len(said))]
    return np.array([seen.joints.position[1:] for seen in said]) - np.array(true)[:, 1:]


def test_at_rest_the_angles_are_true():
    assert np.abs(errors(followed(standing, 400), standing)).max() < 1e-15


def test_without_noise_the_units_are_exact_in_any_motion():
    def motion(time):
        return (0.3, 0.5 + 0.3 * time * time, -1.5 - time), (1.0, 0.6 * time, -1.0)

    assert np.abs(errors(followed(motion, 100, noise=False), motion)).max() < 1e-14


@pytest.mark.parametrize("gravity", [G, 3.7])
def test_a_steady_swing_tilts_each_unit_by_its_own_radius(gravity):
    def swinging(time):
        return (Q[0] + 0.8 * time, *Q[1:]), (0.8, 0.0, 0.0)

    boom_radius = LINKS.base_offset + 2.0 * math.cos(0.5)
    stick_radius = LINKS.base_offset + LINKS.boom * math.cos(0.5) + 1.5 * math.cos(-1.0)
    boom, stick = (-math.atan(radius * 0.8**2 / gravity) for radius in (boom_radius, stick_radius))
    elsewhere = dataclasses.replace(C180.manipulator, gravity=gravity)
    off = errors(followed(swinging, 2000, dataclasses.replace(fitted(), manipulator=elsewhere)), swinging)
    assert off[-1] == pytest.approx((boom, stick - boom), rel=1e-8)
    there = 1.0 - math.exp(-1.0)  # of a lag of 0.5 s after as long
    assert off[99] == pytest.approx((there * boom, there * (stick - boom)), rel=1e-9)


def test_a_boom_that_gathers_speed_misleads_its_unit_by_what_its_place_feels():
    """Against the acceleration of 2 m of boom by hand, through the lag by its integral."""
    rate, constant = 0.4, 0.7

    def gathering(time):
        return (0.0, 0.2 + 0.5 * rate * time * time, -1.5), (0.0, rate * time, 0.0)

    def tilt(time):
        angle, square = 0.2 + 0.5 * rate * time * time, (rate * time) ** 2
        out = 2.0 * (-rate * math.sin(angle) - square * math.cos(angle))
        up = 2.0 * (rate * math.cos(angle) - square * math.sin(angle))
        return math.atan2(out, G + up)

    off = errors(followed(gathering, 300, fitted(time_constant=constant)), gathering)[-1, 0]
    middles = (np.arange(30_000) + 0.5) * 5e-5  # of 1.5 s
    weights = np.exp(-(1.5 - middles) / constant) / constant * 5e-5
    assert off == pytest.approx(np.dot(weights, [tilt(time) for time in middles]), rel=0.005)


def test_any_motion_tilts_what_is_felt_by_the_acceleration_of_the_units_place():
    """Against second differences of the places in space; the filter is fast beside the motion."""
    machine, dt = fitted(time_constant=0.01), 1e-3

    def angles(time):
        return np.array(
            [0.9 * time + 0.1, 0.6 + 0.3 * math.sin(2.0 * time), -1.4 + 0.4 * math.cos(3.0 * time)]
        )

    def motion(time):
        return tuple(angles(time)), tuple((angles(time + 1e-6) - angles(time - 1e-6)) / 2e-6)

    def alpha(time, place):
        before, now, after = (np.array(place(*angles(time + step))) for step in (-1e-4, 0.0, 1e-4))
        felt = (before - 2.0 * now + after) / 1e-8 + (0.0, 0.0, G)
        swing = angles(time)[0]
        return math.atan2(felt[0] * math.cos(swing) + felt[1] * math.sin(swing), felt[2])

    def boom_unit(swing, boom, _stick):
        return tip_position((swing, boom, 0.0), Links(LINKS.base_offset, 2.0, 0.0))

    def stick_unit(*q):
        return tip_position(q, LINKS._replace(stick=1.5))

    off = errors(followed(motion, 900, machine, dt=dt), motion, dt)
    for row in (299, 599, 899):
        felt = (row + 1) * dt - 0.0105  # the lag, and half of the time that a mean acceleration is over
        boom, stick = alpha(felt, boom_unit), alpha(felt, stick_unit)
        assert off[row] == pytest.approx((boom, stick - boom), abs=2e-3)
        assert abs(boom) > 0.03
        assert abs(stick) > 0.03


def test_the_unit_of_the_stick_feels_the_booms_end():
    """A boom upright from rest throws the stick's joint back: both units tilt by their own acceleration."""
    machine = fitted(time_constant=0.01, stick_distance=0.0)

    def upright(time):
        return (0.0, 0.5 * math.pi + 0.25 * time * time, -1.5), (0.0, 0.5 * time, 0.0)

    off = errors(followed(upright, 10, machine), upright)[-1]
    time = 10 * DT
    joint = -LINKS.boom * 0.5, G - LINKS.boom * (0.5 * time) ** 2
    boom = -2.0 * 0.5, G - 2.0 * (0.5 * time) ** 2
    alpha_stick, alpha_boom = math.atan2(*joint), math.atan2(*boom)
    settled = 1.0 - math.exp(-time / 0.01)
    assert off[0] == pytest.approx(settled * alpha_boom, rel=0.01)
    assert off[0] + off[1] == pytest.approx(settled * alpha_stick, rel=0.01)


def test_a_slow_filter_hides_a_short_jerk():
    def jerk(time):
        pulse = 0.3 if time < 0.1 else 0.0
        return (Q[0], Q[1], Q[2]), (0.0, pulse, 0.0)

    worst = [
        np.abs(errors(followed(jerk, 60, fitted(time_constant=constant)), jerk)).max()
        for constant in (0.1, 1.0, 10.0)
    ]
    assert worst[0] > 5.0 * worst[1] > 25.0 * worst[2]


@pytest.mark.parametrize(
    ("changes", "wanted"),
    [
        ({"gyro_noise": 1e-3}, 1e-3 * math.sqrt(DT * 0.5 / 2.0)),
        ({"accelerometer_noise": 0.1}, 0.1 / 9.81 * math.sqrt(DT / (2.0 * 0.5))),
    ],
)
def test_noise_wanders_as_gyro_or_accelerometers_make_it(changes, wanted):
    """White noise behind a filter of T = 0.5 s: s sqrt(dt T/2) of a gyro, s/g sqrt(dt/2T) of the rest."""
    unit, normals = sensor_suite(fitted(**changes), True).channels[-2], np.random.default_rng(4)
    memory, readings = SensorMemory(0.0, 0.0), []
    for normal in normals.standard_normal(100_000).tolist():
        channel, taken_in = filtered(unit, 0.2, 0.0, normal, DT)
        memory, reading = sample(channel, memory, taken_in, DT, normal)
        readings.append(reading)
    assert np.std(readings[1000:]) == pytest.approx(wanted, rel=0.1)


def test_a_gyro_bias_is_a_static_error_of_bias_times_the_filters_time():
    bounds = [
        sensor_suite(fitted(**changes), True, 3) for changes in ({"gyro_bias": 0.01}, {"accuracy": 0.005})
    ]
    of_bias, of_accuracy = (suite.channels[-2].bias for suite in bounds)
    assert of_bias == pytest.approx(of_accuracy) != 0.0


def test_a_static_error_and_steps_are_in_the_reading():
    machine = fitted(accuracy=0.005)
    bias = sensor_suite(machine, True, 0).channels[-2].bias
    assert abs(bias) > 1e-3
    assert followed(standing, 2, machine)[-1].joints.position[1] == pytest.approx(0.5 + bias, abs=1e-12)
    stepped = followed(standing, 2, fitted(resolution=0.07))[-1]
    assert stepped.of_kind("inertial_unit") == pytest.approx((0.49, -0.98))


def test_on_a_bent_link_a_unit_has_its_roots_angle_and_the_acceleration_of_what_is_heavy():
    real = load_machine("c180")
    sensors = dataclasses.replace(real.sensors, inertial_unit=UNIT, joint_angles="inertial_unit")
    crane = dataclasses.replace(real, sensors=sensors)
    p, suite = plant_parameters(crane), sensor_suite(crane, True)
    rest = equilibrium(Q, p)
    ringing = rest.plant.roots.boom._replace(rate=0.5)  # the root alone
    state = sensor_readings.at_rest(rest, p, suite)
    rung = rest._replace(plant=rest.plant._replace(roots=rest.plant.roots._replace(boom=ringing)))
    _, seen = sensor_readings.measure(rung, state, p, DT, suite)
    assert seen.joints.position[1] - suite.channels[-2].bias == pytest.approx(ringing.angle, abs=1e-12)
    assert ringing.angle != pytest.approx(Q[1], abs=1e-4)


def test_a_frozen_unit_of_the_boom_freezes_the_boom_and_the_stick_goes_on():
    def raising(time):
        return (0.3, 0.5 + 0.1 * time, -1.5), (0.0, 0.1, 0.0)

    said = followed(raising, 40, noise=False, faults="boom_inertial_unit: frozen from 0.05 s")
    boom, stick = np.array([seen.joints.position[1:] for seen in said]).T
    assert np.ptp(boom[10:]) == 0.0
    assert stick[-1] == pytest.approx(-1.5 + 0.1 * 0.15, abs=1e-3)


def test_an_absent_unit_takes_its_angles_away():
    said = followed(standing, 2, faults="stick_inertial_unit: absent")
    assert np.isnan(said[-1].joints.position).tolist() == [False, False, True]
    said = followed(standing, 2, faults="boom_inertial_unit: absent")
    assert np.isnan(said[-1].joints.position).tolist() == [False, True, True]
