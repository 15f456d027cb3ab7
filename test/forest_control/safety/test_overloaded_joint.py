"""A load that drives a joint back is seen and named; whatever happens to it, the tip is not thrown."""

import dataclasses

import numpy as np
import pytest

from forest_control.config import controller_settings
from forest_control.limits.velocity_scaling import Limit
from forest_control.operator.levers import Levers, levers_for_tip_velocity
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.geometry.kinematics import tip_velocity
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_suite import CHANNELS, sensor_suite
from forest_sim.simulation.load_schedule import Load, loaded
from forest_sim.solver.compiled_plant import compiled_advance
from forest_study.closed_loop.closed_loop import ClosedLoop, Operator
from forest_study.closed_loop.loop_core import SUBSTEPS

C180 = load_machine("c180_hoses")
CENTRED = Levers(0.0, 0.0, 0.0)
MACHINES = "c180", "c180_hoses"


class Cabled(ClosedLoop):
    """A closed loop whose valves' cable may be cut."""

    cut = False

    def _move(self, volts):
        super()._move(ZERO if self.cut else volts)


class Crane:
    """A crane with noisy sensors whose head can grasp and drop."""

    def __init__(self, name, tip, seed=1, faults=""):
        # What may be lifted is another limit's: here the load comes all the same.
        self.machine = dataclasses.replace(load_machine(name), capacity=None)
        control = controller_settings.parameters(self.machine, controller_settings.Settings())
        drive = valve_driver_parameters.parameters(self.machine, valve_driver_parameters.Settings())
        suite = sensor_suite(self.machine, noise=True, seed=seed, faults=parse_faults(faults))
        self.loop = Cabled(self.plant(0.0), control, drive, pose_at(tip, self.machine), suite, fast=True)
        self.volts = ZERO

    def plant(self, mass):
        return loaded(plant_parameters(self.machine), self.machine.manipulator, Load(mass))

    def grasp(self, mass):
        self.loop.change_load(self.plant(mass))

    def drive(self, velocity, held=True):
        self.volts = self.loop.period(Operator(levers_for_tip_velocity(velocity, 0.5), held)).voltages
        return self.speed(self.loop.simulation)

    def speed(self, simulation):
        """Of the true tip [m/s]."""
        p = simulation.plant
        rates = p.swing.rate, p.boom.rate, p.stick.rate
        angles = p.swing.angle, p.boom.angle, p.stick.angle
        return float(np.linalg.norm(tip_velocity(angles, rates, self.machine.manipulator.links)))

    def rebound(self, mass, volts=ZERO):
        """The tip's greatest speed [m/s] within 1 s under shut valves, or voltages, from now on."""
        simulation, advance, peak = self.loop.simulation, compiled_advance(), 0.0
        for _ in range(round(1.0 / PERIOD)):
            simulation = advance(simulation, volts, PERIOD / SUBSTEPS, SUBSTEPS, self.plant(mass))
            peak = max(peak, self.speed(simulation))
        return peak

    @property
    def cause(self):
        return self.loop.controller.guard.causes["machine"]

    @property
    def limit(self):
        return self.loop.telemetry.output.scaling.limit


@pytest.mark.parametrize("name", ["c180_hoses", "c180"])
@pytest.mark.parametrize(("mass", "tip"), [(1900.0, (5.5, 0.0, 1.0)), (2500.0, (6.5, 0.0, 0.0))])
def test_a_boom_that_its_load_drives_back_is_seen_within_0_3_s_named_and_its_valve_shut(name, mass, tip):
    crane, sinks, seen = Crane(name, tip), None, None
    for k in range(480):
        if k == 240:
            crane.grasp(mass)
        crane.drive((0.0, 0.0, 0.5) if k >= 100 else ZERO)
        if k >= 240 and sinks is None and crane.loop.simulation.plant.boom.rate < -0.01:
            sinks = k
        if seen is None and crane.cause:
            seen = k
            assert crane.cause.startswith("overload: boom went back ")
    assert (seen - sinks) * PERIOD < 0.3
    assert crane.limit == Limit.OVERLOAD
    assert crane.volts == ZERO


@pytest.mark.parametrize("name", ["c180_hoses", "c180"])
def test_once_the_deadman_was_let_go_an_overloaded_crane_puts_its_load_down(name):
    crane = Crane(name, (5.5, 0.0, 1.0))
    for k in range(800):
        if k == 240:
            crane.grasp(1900.0)
        held = not 560 <= k < 570
        crane.drive((0.0, 0.0, 0.5) if 100 <= k < 480 else ZERO if k < 600 else (0.0, 0.0, -0.3), held)
        if 479 <= k < 560:  # centred sticks are no act: taught work's are centred all the time
            assert crane.limit == Limit.OVERLOAD
            assert crane.volts == ZERO
        if k == 600:
            height = crane.loop.telemetry.tip[2]
    assert crane.cause == ""
    assert crane.loop.telemetry.tip[2] < height - 0.15


def test_levers_that_are_thrown_about_are_no_overload():
    for name, seed in (("c180_hoses", 3), ("c180", 4), ("loader", 5)):
        rng = np.random.default_rng(seed)
        far = load_machine(name).manipulator.boom_length + load_machine(name).manipulator.stick_length
        crane, velocity = Crane(name, (0.7 * far, 0.0, 0.3), seed), ZERO
        for k in range(900):
            if k % 70 == 69:
                velocity = tuple(rng.choice([-0.5, 0.0, 0.5], 3).tolist())
            crane.drive(velocity)
            assert crane.cause == "", (name, k)


def events(seed):
    """A wish, where from, and by its period what happens: a grasp, a drop 1 to 1.8 s later, another grasp.

    A joystick that falls silent, a resolver that loses its samples, and a release come to it.
    """
    rng = np.random.default_rng([seed, 77])
    wish = rng.normal(size=3)
    wish *= 0.5 * rng.uniform(0.3, 1.0) / np.linalg.norm(wish)
    tip = tuple(rng.uniform((5.0, -1.0, -1.0), (7.0, 1.0, 1.0)).tolist())
    grasped, held, empty = rng.uniform(0.8, 2.0), rng.uniform(1.0, 1.8), rng.uniform(0.2, 1.0)
    times = np.round(np.cumsum([grasped, held, empty]) / PERIOD).astype(int).tolist()
    masses = rng.uniform(300.0, 4000.0), 0.0, rng.uniform(300.0, 2500.0)
    silent, released = int(rng.uniform(1.0, 4.0) / PERIOD), rng.uniform(4.0, 5.0) / PERIOD
    silent = silent if rng.random() < 0.4 else 10_000
    name, lost = CHANNELS[rng.integers(3)], rng.uniform(1.0, 4.0)
    faults = f"{name}: drop from {lost:.3f} s until {lost + 0.2:.3f} s" if rng.random() < 0.4 else ""
    return tuple(wish.tolist()), tip, dict(zip(times, masses, strict=True)), silent, released, faults


def over_the_bound(name, seed, sooner=0):
    """The tip's speed [m/s] over 1.2 times the wish and 0.1 m/s and what shut valves give, from an event on.

    The drop comes that many periods sooner.
    """
    wish, tip, loads, silent, released, faults = events(seed)
    grasped, dropped, again = sorted(loads)
    loads = {grasped: loads[grasped], dropped - sooner: 0.0, again: loads[again]}
    crane, rebound, over = Crane(name, tip, seed, faults), 0.0, []
    for k in range(1000):
        if k in loads:
            crane.grasp(loads[k])
            rebound = max(rebound, crane.rebound(loads[k]))
        if silent <= k < silent + 40:  # 0.2 s of a joystick that falls silent
            crane.loop.period(None)
            speed = crane.speed(crane.loop.simulation)
        else:
            speed = crane.drive(wish if k >= 100 else ZERO, k < released)
        if k >= grasped:
            over.append(speed - 1.2 * float(np.linalg.norm(wish)) - 0.1 - rebound)
    return max(over)


# Without the overload's rule, or with a bound 50 times as wide, the tip of c180 is thrown at seed 6.
@pytest.mark.parametrize("seed", range(8))
def test_whatever_slips_the_tip_is_not_thrown(seed):
    assert over_the_bound(MACHINES[seed % 2], seed) < 0.05


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("lost", "most"), [((0.1, 0.5), 0.65), ((1.8, 3.0), 0.0)])
def test_whenever_the_valves_cable_comes_back_the_tip_is_not_thrown(seed, lost, most):
    """Beyond what the voltages before would do; soon, a joint that gets its valve back is made up for."""
    rng = np.random.default_rng([seed, 78])
    wish, tip, *_ = events(seed)
    bound, back = 1.2 * float(np.linalg.norm(wish)) + 0.1, 400 + round(rng.uniform(*lost) / PERIOD)
    crane, over = Crane(MACHINES[seed // 2], tip, seed), []
    for k in range(back + 120):
        if k == 400:
            volts, crane.loop.cut = crane.volts, True
        if k == back:
            crane.loop.cut, bound = False, max(bound, crane.rebound(0.0, volts))
        over.append(crane.drive(wish if k >= 100 else ZERO) - bound)
    assert max(over[back:]) < most
    if lost[0] > 1.0:
        assert "though its valve is open" in crane.cause
        assert crane.volts == ZERO
