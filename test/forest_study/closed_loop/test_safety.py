"""Machine, controller, driver and a joystick with faults, in simulated time: the tip stops along its path."""

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.operator import joystick_watch
from forest_control.operator.joystick_watch import NO_HEARTBEAT, Sample, WatchParameters
from forest_control.operator.levers import REST, Levers, levers_for_tip_velocity
from forest_control.operator.operator_profile import Mode
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import inverse_kinematics, tip_position
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_study.closed_loop.closed_loop import ClosedLoop, Operator
from forest_study.closed_loop.compiled_loop import by_heart as run

C180 = load_machine("c180_hoses")
START = inverse_kinematics((5.5, 0.0, 1.0), C180.manipulator.links)
SPEED = 0.5  # [m/s]
FAULT = 1.2  # [s] when something happens to the joystick
WITHIN = 0.25  # [s]
STOPPED = 0.1 * SPEED  # [m/s]
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1), "-z": (0, 0, -1), "xyz": (0.6, 0.6, 0.5)}
TIP_SCHEMES = [scheme for scheme in Scheme if scheme != Scheme.JOINT]


class Stick:
    """A joystick at 100 Hz behind the watch; `fault(time, sample)` gives what the wire makes of a sample."""

    def __init__(self, velocity, fault):
        self.levers = levers_for_tip_velocity(velocity, SPEED)
        self.fault, self.p = fault, WatchParameters()
        self.watch, self.before, self.step = joystick_watch.REST, None, 0

    def __call__(self, time):
        if self.step % 2 == 0:  # every second period of the machine
            shaking = self.levers._replace(boom=self.levers.boom + 1e-6 * np.sin(1e3 * time))
            levers = shaking if time > 0.1 else REST
            sample = self.fault(
                time, Sample(time, round(time * 1e9), NO_HEARTBEAT, False, True, levers, True)
            )
            if sample is not None:
                same = (sample.levers, sample.held) == self.before
                self.before = sample.levers, sample.held
                self.watch = joystick_watch.updated_watch(self.watch, sample._replace(same=same))
        self.step += 1
        self.watch, operator = joystick_watch.assessed_watch(self.watch, time, True, self.p)
        return Operator(*operator)


def session(stick, duration, scheme=Scheme.COORDINATED):
    settings = controller_settings.Settings(scheme=scheme, tip_speed=SPEED)
    return run(C180, stick, duration, START, settings, valve_driver_parameters.Settings())


def stop_from(moved, begun):
    """Return the time [s] until the tip's speed is a tenth, its way and its way aside [m], from a time on."""
    row = round(begun / PERIOD)
    velocity = np.gradient(moved.tip, PERIOD, axis=0)
    along = velocity[row - 2 : row + 1].mean(axis=0)
    along /= np.linalg.norm(along)
    way = moved.tip[row:] - moved.tip[row]
    slow = np.linalg.norm(velocity[row:], axis=1) < STOPPED
    forward = way @ along
    aside = np.linalg.norm(way - np.outer(forward, along), axis=1)
    return PERIOD * np.argmax(slow), forward.max(), aside.max()


def released(time, sample):
    return sample._replace(held=time < FAULT)


def lost(time, sample):
    return sample if time < FAULT else None


def stamp_stands_still(time, sample):
    return sample._replace(stamp=min(sample.stamp, round(FAULT * 1e9)))


def held_still(time, sample):
    return sample if time < 0.2 else sample._replace(levers=sample.levers._replace(boom=0.01))


@pytest.mark.parametrize("direction", AXES.values(), ids=AXES)
def test_let_go_the_tip_stops_along_its_path_within_a_quarter_second_and_70_mm(direction):
    velocity = tuple(SPEED * x for x in direction)
    moved = session(Stick(velocity, released), FAULT + 0.8)
    time, way, aside = stop_from(moved, FAULT)
    assert time <= WITHIN
    assert way < 0.070
    assert aside < 0.005
    shut = round((FAULT + WITHIN) / PERIOD)
    assert not moved.commands[shut:].any()
    assert not moved.voltages[shut:].any()
    stopping = moved.commands[round(FAULT / PERIOD) + 1 : shut]
    assert not ((stopping > 0.0).any(axis=0) & (stopping < 0.0).any(axis=0)).any()  # no valve turns round
    later = moved.tip[shut:]  # the crane rocks on the oil that is shut in its hoses
    assert np.linalg.norm(later - later[-1], axis=1).max() < 0.010


def bounces(time, sample):
    """The levers are let go, and the deadman's contact bounces for 0.4 s."""
    if time < FAULT:
        return sample
    return sample._replace(levers=REST, held=time < FAULT + 0.4 and round(100.0 * time) % 2 == 0)


@pytest.mark.parametrize("direction", AXES.values(), ids=AXES)
def test_let_go_a_deadman_whose_contact_bounces_makes_no_valve_open_further(direction):
    """With centred levers each bounce arms and disarms: none adds to what was commanded."""
    velocity = tuple(SPEED * x for x in direction)
    moved, row = session(Stick(velocity, bounces), FAULT + 0.8), round(FAULT / PERIOD)
    before = np.abs(moved.commands[row - 40 : row]).max(axis=0)
    assert (np.abs(moved.commands[row:]) < 1.5 * before + 0.5).all()
    speed = np.linalg.norm(np.gradient(moved.tip, PERIOD, axis=0), axis=1)
    assert speed[row:].max() < 1.2 * SPEED + 0.1
    assert not moved.voltages[row + round(0.65 / PERIOD) :].any()


# Start [deg], levers' deflections and for how long [s]; what ails the crane when the deadman is let go.
MOTIONS = {
    "swing behind its reference": (
        "c180_hoses",
        (85.4, 58.0, -53.2),
        [(0.855, (0.09, -0.68, 0.14)), (1.29, (-0.5, 0.05, -0.17)), (1.48, (0.49, -0.06, 0.08))],
    ),
    "swing rocks": (
        "c180_hoses",
        (176.0, 48.1, -72.8),
        [(0.955, (-0.37, -0.66, -0.26)), (0.36, (0.95, 0.02, 0.32))],
    ),
    "swing on soft hoses": (
        "loader",
        (178.4, 24.3, -110.8),
        [(1.35, (-0.73, -0.3, -0.62)), (1.21, (0.72, -0.46, 0.49))],
    ),
    "levers just thrown": (
        "loader",
        (-101.8, 19.1, -50.0),
        [(0.27, (-0.44, -0.49, 0.65)), (1.47, (-0.51, 0.1, -0.21)), (0.215, (0.77, 0.45, 0.45))],
    ),
}


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_let_go_in_the_midst_of_a_wild_motion_it_stops_as_soon(motion):
    name, start, wishes = motion
    held = [Operator(Levers(*levers)) for time, levers in wishes for _ in range(round(time / PERIOD))]
    rows = [Operator(REST)] * 20 + held + [Operator(REST, False)] * 120
    settings = controller_settings.Settings(tip_speed=SPEED), valve_driver_parameters.Settings()

    def operator(time):
        return rows[round(time / PERIOD)]

    pose = tuple(np.radians(start).tolist())
    moved = run(load_machine(name), operator, PERIOD * len(rows), pose, *settings)
    time, way, _ = stop_from(moved, PERIOD * (20 + len(held)))
    assert time <= WITHIN
    assert way < 0.070


@pytest.mark.parametrize("scheme", TIP_SCHEMES)
def test_every_tip_scheme_stops_within_70_mm(scheme):
    moved = session(Stick((0.0, 0.0, SPEED), released), FAULT + 0.6, scheme)
    time, way, _ = stop_from(moved, FAULT)
    assert time <= WITHIN
    assert way < 0.070
    assert not moved.commands[round((FAULT + WITHIN) / PERIOD) :].any()


@pytest.mark.parametrize(
    ("fault", "found"), [(lost, 0.15), (stamp_stands_still, 0.15)], ids=["lost", "stamp stands still"]
)
def test_a_lost_joystick_stops_the_tip_within_its_timeout_and_a_quarter_second(fault, found):
    moved = session(Stick((SPEED, 0.0, 0.0), fault), FAULT + 1.0)
    time, way, aside = stop_from(moved, FAULT)
    assert time <= found + WITHIN
    assert way < 0.070 + (found + 0.01) * SPEED
    assert aside < 0.005
    assert not moved.commands[round((FAULT + found + 0.01 + WITHIN) / PERIOD) :].any()


def test_a_device_that_hangs_stops_the_tip_half_a_second_and_a_quarter_later():
    """Its noise was known from 45 s before, in which the crane stood, disarmed."""
    stick = Stick((0.0, -0.3, 0.0), held_still)
    stick.watch = stick.watch._replace(restless=45.0)
    moved = session(stick, 2.0)
    assert stick.watch.joystick == joystick_watch.Joystick.FROZEN
    frozen = 0.2 + joystick_watch.QUICK
    assert np.abs(moved.tip_wish[round((frozen - 0.05) / PERIOD)]).max() > 0.29
    assert not moved.commands[round((frozen + 0.02 + WITHIN) / PERIOD) :].any()


def test_the_deadman_pressed_with_a_deflected_stick_moves_nothing():
    stick = Stick((SPEED, 0.0, 0.0), lambda time, sample: sample if time > 0.1 else None)
    assert not session(stick, 1.0).voltages.any()


def test_pressed_again_while_it_stops_it_goes_on_without_a_jump():
    def again(time, sample):
        held = not FAULT <= time < FAULT + 0.03
        centred = FAULT <= time < FAULT + 0.06
        return sample._replace(held=held, levers=REST if centred else sample.levers)

    moved = session(Stick((SPEED, 0.0, 0.0), again), FAULT + 1.0)
    assert np.abs(moved.tip_wish[-1] - (SPEED, 0.0, 0.0)).max() < 1e-3
    assert np.abs(np.diff(moved.tip_wish, axis=0)).max() < 0.05


@pytest.mark.parametrize("direction", [(-1, 0, 1), (1, 1, 1)], ids=["in and up", "out, left and up"])
def test_at_full_speed_into_a_limit_the_tip_keeps_its_line_stops_just_before_it_and_comes_back(direction):
    along, pushed = np.array(direction) / np.linalg.norm(direction), 6.0
    forth, back = (levers_for_tip_velocity(tuple(v * along), 1.0) for v in (1.0, -0.5))

    def operator(time):
        return Operator(forth if time < pushed else REST if time < pushed + 0.3 else back)

    settings = controller_settings.Settings(tip_speed=1.0)
    moved = run(C180, operator, pushed + 1.3, START, settings, valve_driver_parameters.Settings())
    arrived = round(pushed / PERIOD)
    way = moved.tip - moved.tip[0]
    aside = np.linalg.norm(way - np.outer(way @ along, along), axis=1)
    low, high = np.array(joint_limits(C180)).T
    margin = np.degrees(np.minimum(moved.angles - low, high - moved.angles))
    assert aside[:arrived].max() < 0.005
    assert margin.min() > 0.49
    assert margin[arrived].min() < 3.0
    assert (way[arrived] - way[-1]) @ along > 0.3


def test_from_outside_its_limits_the_crane_comes_back_and_goes_no_further_out():
    low = np.array(joint_limits(C180))[:, 0]
    start = (0.3, 0.4, float(low[2]) + np.radians(0.2))  # within the margin that is kept
    for push, inwards in ((Levers(0.0, 0.0, -1.0), False), (Levers(0.0, 0.0, 1.0), True)):
        settings = controller_settings.Settings(scheme=Scheme.COORDINATED)
        moved = run(
            C180, lambda _, p=push: Operator(p), 1.5, start, settings, valve_driver_parameters.Settings()
        )
        gone = np.degrees(moved.angles[-1][2] - start[2])
        assert gone > 1.0 if inwards else abs(gone) < 0.15


THERE = levers_for_tip_velocity((0.2, 0.25, 0.2), SPEED)
BACK = Levers(-THERE.swing, -THERE.boom, -THERE.stick)


def mad_settings(rng):
    """Scheme, mode and speed by chance."""
    scheme, mode = Scheme(int(rng.integers(1, 6))), Mode(int(rng.integers(2)))
    return controller_settings.Settings(scheme=scheme, mode=mode, tip_speed=float(rng.choice([0.05, SPEED])))


def test_settings_that_change_100_times_a_second_do_not_make_the_tip_run():
    rng = np.random.default_rng(0)
    pool = [controller_settings.parameters(C180, mad_settings(rng)) for _ in range(40)]
    drive = valve_driver_parameters.parameters(C180, valve_driver_parameters.Settings())
    loop = ClosedLoop(plant_parameters(C180), pool[0], drive, START, sensor_suite(C180))
    tips = []
    for k in range(1000):
        if k % 2 == 0:
            loop.controller.tune(pool[int(rng.integers(40))])
        levers = REST if k < 60 else (THERE, BACK)[k // 200 % 2]
        tips.append(tip_position(loop.period(Operator(levers)).angles, C180.manipulator.links))
    speeds = np.linalg.norm(np.gradient(np.array(tips), PERIOD, axis=0), axis=1)
    assert speeds.max() < 1.6 * SPEED  # 1.3 m/s if every change were heeded at once
