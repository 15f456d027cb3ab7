"""Machine, controller and driver together in simulated time: tracking, limits, standing still when told."""

import dataclasses

import numpy as np
import pytest
from recorded import recorded

from forest_control.config import controller_settings
from forest_control.operator.joystick_sources import read_levers, thesis_levers
from forest_control.operator.levers import REST, Levers
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_study.closed_loop.closed_loop import Operator
from forest_study.closed_loop.compiled_loop import by_heart as run

C180 = load_machine("c180_hoses")
START = inverse_kinematics((5.5, 0.0, 1.0), C180.manipulator.links)


def session(operator, duration, scheme=Scheme.JACOBIAN_POSITION, start=START, **options):
    settings = controller_settings.Settings(scheme=scheme)
    return run(C180, operator, duration, start, settings, valve_driver_parameters.Settings(), **options)


def thesis(time):
    return Operator(thesis_levers(time, controller_settings.Settings().tip_speed))


def rms_mm(trajectory):
    return 1e3 * np.sqrt(np.mean(np.sum(trajectory.tip_error() ** 2, axis=1)))


@pytest.fixture(scope="module")
def scheme_d():
    """The thesis' session in scheme (d)."""
    return session(thesis, 10.0)


def test_scheme_d_tracks_the_thesis_input_under_90_mm(scheme_d):
    assert rms_mm(scheme_d) < 90.0


def test_scheme_c_tracks_the_thesis_input_under_90_mm():
    assert rms_mm(session(thesis, 10.0, Scheme.JACOBIAN_VELOCITY)) < 90.0


def test_pressures_stay_between_tank_and_what_relief_allows(scheme_d):
    pressures = scheme_d.pressures
    assert pressures.min() > -1e5
    assert pressures.max() < C180.port_valves.relief_pressure + 1.5e6


def test_compensation_is_what_makes_it_track(scheme_d):
    """The same session with the driver's compensation off: the overlap eats the command."""
    off = valve_driver_parameters.Settings(compensate=False)
    blind = run(C180, thesis, 10.0, START, controller_settings.Settings(scheme=Scheme.JACOBIAN_POSITION), off)
    assert rms_mm(blind) > 1.5 * rms_mm(scheme_d)


def sensing(text="", noise=False, seed=0):
    return sensor_suite(C180, noise, seed, parse_faults(text))


def test_with_real_sensors_it_still_tracks_and_equal_seeds_repeat_exactly():
    one, same, other = (session(thesis, 5.0, suite=sensing("", True, seed)) for seed in (1, 1, 2))
    assert np.array_equal(one.tip, same.tip)
    assert np.array_equal(one.pressures, same.pressures)
    assert not np.array_equal(one.tip, other.tip)
    assert max(rms_mm(one), rms_mm(other)) < 100.0


def test_a_suite_without_noise_is_the_exact_session():
    assert np.array_equal(session(thesis, 2.0).tip, session(thesis, 2.0, suite=sensing()).tip)


@pytest.mark.parametrize("scheme", list(Scheme))
def test_a_joint_that_is_lost_shuts_every_valve_at_once(scheme):
    moved = session(thesis, 2.0, scheme, suite=sensing("boom_resolver: absent from 1.5 s"))
    lost = round(1.5 / PERIOD)
    assert np.abs(moved.voltages[: lost - 1]).max() > 1.0
    assert not moved.voltages[lost:].any()
    assert not moved.tip_wish[lost:].any()


def test_without_a_pressure_the_driver_takes_the_nominal_load():
    blind = session(thesis, 3.0, suite=sensing("stick_pressure_1_actuator: absent"))
    seeing = session(thesis, 3.0)
    assert np.isnan(blind.pressures).any(axis=0).sum() == 1
    assert rms_mm(blind) > 0.9 * rms_mm(seeing)
    assert not np.array_equal(blind.tip, seeing.tip)
    assert np.isfinite(blind.tip).all()


def margins(trajectory):
    low, high = np.array(joint_limits(C180)).T
    return np.minimum(trajectory.angles.min(axis=0) - low, high - trajectory.angles.max(axis=0))


def wild_levers(seed):
    """Return levers that jump to random deflections, now and then to rest, each held for a random while."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.05, 4.0, 60))
    values = np.clip(rng.normal(0.0, 1.2, (61, 3)), -1.0, 1.0) * (rng.random((61, 1)) > 0.2)
    return lambda time: Operator(Levers(*values[np.searchsorted(times, time)].tolist()))


@pytest.mark.parametrize("scheme", list(Scheme))
@pytest.mark.parametrize("seed", [2])
def test_no_lever_motion_takes_a_joint_over_its_limit(scheme, seed):
    assert np.all(margins(session(wild_levers(seed), 40.0, scheme)) > 0.0)


@pytest.mark.parametrize("scheme", list(Scheme))
def test_a_persons_hands_keep_every_joint_inside_its_limits(scheme):
    record = read_levers(recorded("operator_levers.csv"))
    moved = session(lambda time: Operator(record.at(time)), 100.0, scheme)
    assert np.all(margins(moved) > 0.0)
    assert np.ptp(moved.angles, axis=0).max() > 0.1  # and it did drive the crane
    if scheme is Scheme.JACOBIAN_POSITION:
        assert np.linalg.norm(moved.tip_error()[-1]) < 0.1  # m: it lags, but it does not drift away


@pytest.mark.parametrize("scheme", list(Scheme))
def test_releasing_the_deadman_shuts_the_valves_and_stops_the_tip(scheme):
    levers = Levers(1.0, 0.5, -0.5)
    moved = session(lambda time: Operator(levers, enabled=time < 1.5), 6.0, scheme)
    released = round((1.5 + 0.25) / PERIOD)
    assert np.abs(moved.voltages[:released]).max() > 1.0
    assert not moved.voltages[released:].any()
    # What is left after two seconds is the swing rocking on the oil shut in its hoses.
    later = moved.tip[released + round(2.0 / PERIOD) :]
    assert np.ptp(later, axis=0).max() < 0.1
    assert np.ptp(moved.tip[-20:], axis=0).max() < 0.01


def test_without_a_wish_nothing_moves_and_no_valve_opens():
    still = session(lambda _: Operator(REST), 5.0)
    assert not still.voltages.any()
    assert np.ptp(still.angles, axis=0).max() < 1e-9


def test_a_controller_that_believes_another_machine_still_keeps_limits():
    import dataclasses

    heavier = dataclasses.replace(C180.manipulator, head_mass=2 * C180.manipulator.head_mass)
    other = dataclasses.replace(C180, manipulator=heavier)
    moved = run(
        other,
        wild_levers(3),
        30.0,
        START,
        controller_settings.Settings(),
        valve_driver_parameters.Settings(),
        model=C180,
    )
    assert np.all(margins(moved) > 0.0)


def test_before_the_first_report_a_period_passes_under_shut_valves():
    """As live; on a slope the swing has begun to leak downhill by then."""
    tilted = dataclasses.replace(
        C180, manipulator=dataclasses.replace(C180.manipulator, platform_tilt=np.radians(10.0))
    )
    start = (0.5, *START[1:])
    still = run(
        tilted,
        lambda _: Operator(REST, False),
        2 * PERIOD,
        start,
        controller_settings.Settings(),
        valve_driver_parameters.Settings(),
    )
    assert still.angles[0] != pytest.approx(start, abs=1e-12)
    assert still.angles[0] == pytest.approx(start, abs=1e-4)
