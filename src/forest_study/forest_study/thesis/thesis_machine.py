"""The study of Thesis section 5.2 on the full nonlinear machine: what the thesis left open.

The same input from the same place, 10 s, by the graph's own cores in one loop at 200 Hz: pump, valves, hoses,
crane; sensors as sampled, exact; the driver with its compensation. What the linear plant's natural frequency
w_n was, is here the first-order lag of the valves' spools:

| plant | spools | gains of (a) to (d) | of `coordinated` |
|---|---|---|---|
| as built | 12 Hz | the graph's | the graph's |
| 2 Hz | 2 Hz | the thesis' for 2 Hz | K_p below, K_i as on the linear plant, T longer by the lag |
| 0.2 Hz | 0.2 Hz | the thesis' for 0.2 Hz | alike; D = 2 sqrt(K_p/w_n) - 1 damps K_p with the lag fully |

A mismatch m makes the valves' flow 1/(1 + m) of what controller and driver believe, and the spools (1 + m)
times as fast: the linear plant's joint with k fixed. Errors, drifts and signs as in `thesis_study`. Scheme
(d) takes J^-1 at the measured angles, as in the thesis. `joint` has an operator who solves the kinematics of
the wish by heart and plays the levers accordingly, without looking.
"""

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np

from forest_control.config import controller_settings
from forest_control.operator.joystick_sources import THESIS_DURATION, thesis_levers, thesis_tip_velocity
from forest_control.operator.levers import REST, Levers
from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import THESIS_START
from forest_description.geometry.kinematics import inverse_kinematics, joint_rates
from forest_description.machine import Machine, load_machine
from forest_description.types import Vec3
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop import compiled_loop
from forest_study.closed_loop.closed_loop import Operator
from forest_study.thesis.thesis_plant import DRIVE, Motion
from forest_study.thesis.thesis_schemes import INTEGRAL_SHARE
from forest_study.thesis.thesis_study import COORDINATES, MISMATCHES, POLES, SINUSOID, Case, metrics
from forest_study.thesis.thesis_study import gains as thesis_gains

MACHINE = "c180_hoses"
REST_BEFORE = 1.0  # [s] in which the coordinated scheme finds the pose that it starts from
TIP_SPEED = 0.6  # [m/s] at full deflection; the input needs 0.47
# [1/s] K_p of `coordinated`. More than w_n/6.25 lets the crane rock on its hoses at 2.3 Hz; a spool of 0.2 Hz
# lets little of that through.
FEEDBACK = {2.0: 2.0, 0.2: 5.0}
WRONG = (-0.2, 0.2)

Plant = float | None
"""Bandwidth of the spools [Hz]; None: as built."""
PLANTS: dict[str, Plant] = {"as built": None, "2 Hz": 2.0, "0.2 Hz": 0.2}


class Trial(NamedTuple):
    """A scheme on a plant that is not quite the one it believes."""

    scheme: Scheme
    plant: str = "as built"
    mismatch: float = 0.0


def machine_of(plant: str, mismatch: float = 0.0) -> Machine:
    """Return the machine with spools of a bandwidth and valves that are off by a mismatch."""
    machine = load_machine(MACHINE)
    bandwidth = PLANTS[plant] or machine.valve.spool_bandwidth
    assert bandwidth is not None  # the machine's own file has one
    valve = dataclasses.replace(
        machine.valve,
        spool_bandwidth=bandwidth * (1.0 + mismatch),
        minimum_resistance=machine.valve.minimum_resistance * (1.0 + mismatch) ** 2,
    )
    return dataclasses.replace(machine, valve=valve)


def settings_of(scheme: Scheme, plant: str) -> controller_settings.Settings:
    """Return the controller's settings made for a plant. Thesis section 5.2.1, 5.2.2."""
    made = controller_settings.with_rules(
        machine_of(plant),
        controller_settings.Settings(scheme=scheme, tip_speed=TIP_SPEED, jacobian_at_joints=True),
    )
    bandwidth = PLANTS[plant]
    if bandwidth is None:
        return made
    w_n, servo = 2.0 * math.pi * bandwidth, thesis_gains(Case(bandwidth))
    # The graph's servos ask for rates, the thesis' drive a plant whose rate is W_0/w_n times that.
    scale, k_p = DRIVE / w_n, FEEDBACK[bandwidth]
    damping = 2.0 * math.sqrt(k_p / w_n) - 1.0
    spools = load_machine(MACHINE).valve.spool_bandwidth
    lag = 1.0 / w_n - (0.0 if spools is None else 1.0 / (2.0 * math.pi * spools))
    return made._replace(
        velocity_gain=_three(scale * servo.velocity_gain),
        position_gain=_three(scale * servo.position_gain),
        damping_gain=_three(scale * servo.damping_gain),
        feedback_gain=_three(k_p),
        integral_gain=_three(INTEGRAL_SHARE * k_p**2),
        rate_gain=(
            max(made.rate_gain[0], damping),
            max(made.rate_gain[1], damping),
            max(made.rate_gain[2], damping),
        ),
        lead_time=(made.lead_time[0] + lag, made.lead_time[1] + lag, made.lead_time[2] + lag),
    )


def motion(trial: Trial) -> Motion:
    """Return the motion of a trial: the thesis' input, 10 s from (5.5, 0, 1) m."""
    machine, model = machine_of(trial.plant, trial.mismatch), machine_of(trial.plant)
    settings, links = settings_of(trial.scheme, trial.plant), model.manipulator.links
    start = inverse_kinematics(THESIS_START, links)
    by_heart = _levers_by_heart(start, settings, model) if trial.scheme == Scheme.JOINT else None

    def operator(time: float) -> Operator:
        row = round((time - REST_BEFORE) / PERIOD)
        if row < 0:
            return Operator(REST)
        return Operator(by_heart[row] if by_heart else thesis_levers(PERIOD * row, TIP_SPEED))

    duration = REST_BEFORE + THESIS_DURATION + PERIOD
    drive = valve_driver_parameters.Settings(adapt=False)  # who learns the mismatch hides what it costs
    moved = compiled_loop.by_heart(machine, operator, duration, start, settings, drive, model)
    first = round(REST_BEFORE / PERIOD)
    time, tip = moved.time[first:] - REST_BEFORE, moved.tip[first:]
    wished = np.array([thesis_tip_velocity(PERIOD * k) for k in range(len(time))])
    place = tip[0] + np.vstack([np.zeros(3), np.cumsum(wished[:-1], axis=0) * PERIOD])
    return Motion(
        time=time,
        wished_velocity=wished,
        velocity=np.gradient(tip, PERIOD, axis=0),
        wished_position=place,
        position=tip,
    )


def _levers_by_heart(start: Vec3, settings: controller_settings.Settings, model: Machine) -> list[Levers]:
    """Return the joint scheme's levers of every period: J^-1 of the wish at the pose that it should reach."""
    q, links, levers = start, model.manipulator.links, []
    for k in range(round(THESIS_DURATION / PERIOD) + 1):
        a = joint_rates(q, thesis_tip_velocity(PERIOD * k), links)
        swing, boom, stick = (v / most for v, most in zip(a, settings.joint_rates, strict=True))
        levers.append(Levers(swing, boom, stick))
        q = q[0] + PERIOD * a[0], q[1] + PERIOD * a[1], q[2] + PERIOD * a[2]
    return levers


def found(trial: Trial) -> dict[str, float]:
    """Return a trial's metrics as on the linear plant, and the largest on any axis and the RMS [m]."""
    moved = motion(trial)
    numbers = metrics(moved)
    numbers["position_error"] = max(numbers[f"position_error_{axis}"] for axis in COORDINATES)
    numbers["position_rms"] = float(np.sqrt(np.mean(np.sum(moved.position_error**2, axis=1))))
    return numbers


def study() -> dict[str, Any]:
    """Return everything that the machine's `study.json` holds; SI units, shares as numbers."""
    schemes = list(Scheme)
    wrong = {f"2 Hz {m:+.0%}": {s.label: found(Trial(s, "2 Hz", m)) for s in schemes} for m in WRONG}
    return {
        "plants": {name: {s.label: found(Trial(s, name)) for s in schemes} for name in PLANTS} | wrong,
        "mismatch_sweep": [
            {"mismatch": m, **{s.label: found(Trial(s, "as built", m)) for s in schemes}} for m in MISMATCHES
        ],
        "machine": MACHINE,
        "start_tip": list(THESIS_START),
        "duration": THESIS_DURATION,
        "poles": POLES,
        "sinusoid_hz": SINUSOID,
        "period": PERIOD,
    }


def _three(value: float) -> Vec3:
    return value, value, value
