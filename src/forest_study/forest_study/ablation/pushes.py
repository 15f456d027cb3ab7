"""Pushes: the levers are thrown anywhere, any way, then let go; does the tip come to rest where it should?"""

import dataclasses
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from forest_control.operator.levers import REST, Levers, levers_for_tip_velocity
from forest_description.derived.limits import joint_limits
from forest_description.hydraulics.valve_parameters import BackwardValve
from forest_description.machine import Machine
from forest_description.types import AXES, Floats, Vec3
from forest_ident.measurements.parameter_path import with_part
from forest_msgs_py.types import PERIOD
from forest_study.ablation.constants import Settings
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.closed_loop import Operator, Trajectory
from forest_study.tracking.tracking import noisy

PUSHED, RELEASED, QUIET, END = 0.5, 1.5, 4.0, 7.5  # [s] of a session; from `QUIET` on it should be at rest
FULL_SPEED = 0.5  # [m/s] of the tip at full deflection
CYCLING = 0.5  # [V/s] mean variation of a voltage that counts as a limit cycle
DITHERED = 4  # [periods] of the driver's dither, 50 Hz: what a valve is told beside it is their mean
STREAM = 77  # of random numbers: apart from the sensors' noise


class Push(NamedTuple):
    """A push."""

    start: Vec3  # joint angles [rad]
    thrown: Levers  # from `PUSHED` to `RELEASED`

    def operator(self, time: float) -> Operator:
        """Return what the operator does at a time [s]."""
        return Operator(self.thrown if PUSHED < time < RELEASED else REST)


class Rest(NamedTuple):
    """What was left of a push."""

    variation: float  # [V/s] of the busiest valve from `QUIET` on, without its dither
    error: float  # [m] of the tip, greatest mean over half a second from `QUIET` on

    @property
    def cycles(self) -> bool:
        """Whether a valve still moves."""
        return self.variation > CYCLING


def push(machine: Machine, seed: int) -> Push:
    """Return a seed's push: 5 to 50 cm/s for a second, any way, from anywhere 0.12 rad within the limits."""
    rng = np.random.default_rng([seed, STREAM])
    limits = np.clip(joint_limits(machine), [[-1.5], [-9.0], [0.15 - np.pi]], [[1.5], [9.0], [-0.15]])
    swing, boom, stick = rng.uniform(limits[:, 0] + 0.12, limits[:, 1] - 0.12)
    velocity = rng.normal(size=3)
    velocity *= rng.uniform(0.05, 0.5) / np.linalg.norm(velocity)
    x, y, z = velocity.tolist()
    return Push((swing, boom, stick), levers_for_tip_velocity((x, y, z), FULL_SPEED))


def activity(voltages: Floats) -> float:
    """Return the mean of |dV/dt| of the busiest valve [V/s]; voltages [N, 3] a row a period."""
    return float(np.abs(np.diff(voltages, axis=0)).mean(axis=0).max()) / PERIOD


def rest(moved: Trajectory) -> Rest:
    """Return what was left of a push."""
    first, window = round(QUIET / PERIOD), round(0.5 / PERIOD)
    sums = np.cumsum(moved.tip_error()[first:], axis=0)
    means = (sums[window:] - sums[:-window]) / window
    told = sliding_window_view(moved.voltages[first:], DITHERED, axis=0).mean(axis=-1)
    return Rest(activity(told), float(np.linalg.norm(means, axis=1).max()))


def misjudged(machine: Machine, share: float, axes: tuple[int, ...] = (0, 1, 2)) -> Machine:
    """Return the machine as believed by who takes some axes' overlaps for so many times the true ones."""
    for axis in axes:
        valve = machine.valve_of(axis)
        back = BackwardValve(share * valve.law.backward.deadband_voltage, valve.law.backward.resistance_1)
        believed = dataclasses.replace(valve, deadband_voltage=share * valve.deadband_voltage, backward=back)
        machine = with_part(machine, f"{AXES[axis]}.valve", believed)
    return machine


def pushed(machine: Machine, seed: int, overlap: float, tilt: float, settings: Settings) -> Rest:
    """Return what is left of a push of a crane on a slope [rad], its overlap misjudged."""
    crane, given = machine.manipulator, push(machine, seed)
    sloped = dataclasses.replace(crane, platform_tilt=crane.platform_tilt + tilt)
    plant, model = dataclasses.replace(machine, manipulator=sloped), misjudged(machine, overlap)
    suite = noisy(plant, seed)
    return rest(compiled_loop.by_heart(plant, given.operator, END, given.start, *settings, model, suite))
