"""The crane in each state, as a seed draws it: where it stands, where the operator wants to go.

Each scene is asked period by period. In an experiment nobody drives: a scripted operator has the valves.
"""

import math
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np

from forest_control.config import controller_settings
from forest_control.operator.levers import REST, Levers, levers_for_tip_velocity
from forest_control.operator.operator_profile import Mode
from forest_control.taught.cycle import Cycle
from forest_control.taught.cycle import Path as TaughtPath
from forest_control.taught.cycle_file import save_cycle
from forest_control.valve import valve_driver_parameters
from forest_description.derived.limits import pose_at
from forest_description.machine import Machine, load_machine
from forest_description.types import AXES, ZERO, Vec3
from forest_ident.driving.safety_monitor import Readings, monitored_ports
from forest_ident.driving.scripted_operator import ScriptedOperator
from forest_ident.experiments import experiment_plan
from forest_ident.experiments.experiment_plan import Plan
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_suite import Suite, calibrated, sensor_suite
from forest_study.closed_loop.closed_loop import Operator
from forest_study.closed_loop.loop_core import Happened
from forest_study.faults.fault import State
from forest_study.faults.faulty_loop import FaultyLoop, Wires
from forest_study.tracking.taught_loop import TaughtLoop

SPEED = 0.5  # [m/s] of the tip at full deflection
BEGUN = 0.3  # [s] with centred levers
LIMIT_REACH = 7.2  # [m] from where the stick's end is near
STATE_TIMEOUT = 0.1  # [s] of the scripted operator, its default
CYCLE = "round"
# [m] places of the cycle: 12 s at 0.4 m/s.
ROUND: tuple[Vec3, ...] = (
    *((5.5, 0.0, 0.8), (6.3, 0.9, 0.8), (6.3, 0.9, 1.5), (5.3, -0.4, 1.2), (5.5, 0.0, 0.8)),
)


class Scene(Protocol):
    """A crane in a state."""

    def period(self, held: bool, driven: bool) -> Happened:
        """Return what happened in a period; held: the deadman is; driven: the operator wants to move."""

    def resume(self) -> None:
        """Do what else than centring a person must do to go on."""

    def told(self) -> str:
        """Return what the operator is told, or ""."""


class Lot(NamedTuple):
    """What a seed draws of a state."""

    start: Vec3  # [m] of the tip
    levers: Levers
    sway: float  # [rad/s] at which the levers go to and fro; 0: they stay


def lot(state: State, seed: int) -> Lot:
    """Return a seed's lot; every state has its own stream."""
    rng = np.random.default_rng([seed, tuple(State).index(state)])
    way = rng.normal(size=3)
    way *= SPEED * rng.uniform(0.5, 1.0) / np.linalg.norm(way)
    start = tuple(rng.uniform((5.2, -0.8, -0.2), (6.3, 0.8, 1.4)).tolist())
    levers = levers_for_tip_velocity((float(way[0]), float(way[1]), float(way[2])), SPEED)
    if state == State.STANDING:
        return Lot(start, REST, 0.0)
    if state == State.LIMIT:
        return Lot(
            (LIMIT_REACH, 0.0, float(start[2])), Levers(0.3 * levers.swing, 0.3 * levers.boom, 1.0), 0.0
        )
    return Lot(start, levers, 2.0 if state == State.POSITION else 0.0)


class ByHand:
    """A crane that levers move, in rate or position mode.

    Args:
        machine: what is simulated.
        state: other than taught work or an experiment.
        wires: with the fault.
        seed: of places, levers and sensors.
    """

    def __init__(self, machine: Machine, state: State, wires: Wires, seed: int) -> None:
        self._lot, self._state, self._side = lot(state, seed), state, 1.0
        mode = Mode.POSITION if state == State.POSITION else Mode.RATE
        control = controller_settings.Settings(mode=mode, tip_speed=SPEED)
        believed = load_machine(wires.fault.file) if wires.fault.file else machine
        self._loop = FaultyLoop(
            wires,
            plant_parameters(machine),
            controller_settings.parameters(believed, control),
            valve_driver_parameters.parameters(believed, valve_driver_parameters.Settings()),
            pose_at(self._lot.start, machine),
            suite_with(machine, wires, seed),
        )
        self.told = self._loop.told

    def period(self, held: bool, driven: bool) -> Happened:
        """Return what happened in a period."""
        levers, sway = self._lot.levers, self._lot.sway
        part = self._side * (0.6 + 0.4 * math.sin(sway * self._loop.now) if sway else 1.0)
        pushed = Levers(part * levers.swing, part * levers.boom, part * levers.stick)
        return self._loop.period(Operator(pushed if driven else REST, held))

    def resume(self) -> None:
        """Drive back: the way on may have ended at a limit, where nothing is allowed."""
        if self._state in (State.MOTION, State.LIMIT):
            self._side = -1.0


class Taught:
    """A crane that plays a taught cycle; arguments as of `ByHand`."""

    def __init__(self, machine: Machine, _state: State, wires: Wires, seed: int) -> None:
        far = 0.1 * np.random.default_rng([seed, 4]).uniform(-1.0, 1.0, 3)
        points = tuple((x + float(far[0]), y + float(far[1]), z + float(far[2])) for x, y, z in ROUND)
        self._folder = tempfile.TemporaryDirectory()
        folder = Path(self._folder.name)
        save_cycle(Cycle(CYCLE, (TaughtPath(CYCLE, points, 0.4),)), folder)
        late = wires.later(PERIOD)  # a taught loop has made its first step already
        suite, make = suite_with(machine, late, seed), partial(FaultyLoop, late)
        self._taught = TaughtLoop(machine, points[0], folder, suite=suite, make=make)
        self._taught.work.cycle, self._played = CYCLE, False
        loop = self._taught.loop
        assert isinstance(loop, FaultyLoop)
        self.told = loop.told

    def period(self, held: bool, driven: bool) -> Happened:
        """Return what happened in a period; the sticks are centred."""
        if driven and not self._played:
            self._played, _ = True, self._taught.work.play()
            self._folder.cleanup()
        return self._taught.period(Operator(REST, held))

    def resume(self) -> None:
        """Have the cycle resumed, which a person must."""
        self._taught.work.actions["resume"]()


class Experiment:
    """A crane in an experiment; arguments as of `ByHand`."""

    def __init__(self, machine: Machine, _state: State, wires: Wires, seed: int) -> None:
        plan = experiment_plan.plan(f"damping_{AXES[seed % 3]}", machine, seed)
        crane, bare = plan.machine, valve_driver_parameters.Settings(compensate=False)
        self._loop = ExperimentLoop(
            wires,
            plan,
            plant_parameters(crane),
            controller_settings.parameters(crane, controller_settings.Settings()),
            valve_driver_parameters.parameters(crane, bare),
            plan.angles,
            suite_with(crane, wires, seed),
        )
        self.told = self._loop.told

    def period(self, _held: bool, _driven: bool) -> Happened:
        """Return what happened in a period; nobody drives."""
        return self._loop.period(None)

    def resume(self) -> None:
        """Do nothing: an experiment that is over is begun anew."""


class ExperimentLoop(FaultyLoop):
    """A loop whose valves a scripted operator has; the controller's hands are off.

    Args:
        wires: with the fault.
        plan: of the experiment.
        arguments: of `FaultyLoop`.
    """

    def __init__(self, wires: Wires, plan: Plan, *arguments: Any) -> None:
        super().__init__(wires, *arguments)
        self._operator = ScriptedOperator(plan, STATE_TIMEOUT, 0.0)
        self._operator.begin()
        places = (label.split("_") for label in monitored_ports(plan))
        self._ports = [4 * AXES.index(axis) + 2 * int(port) - 1 for axis, port, _ in places]
        self._pressures, self._received, self._reason = tuple[float, ...](), 0.0, ""

    def told(self) -> str:
        """Return what the operator is told, or ""."""
        return self._reason or self._driver_says()

    def _control(self, now: float) -> None:
        if self._reason:
            return  # the operator's node has ended
        for stamp, seen in self._states.arrived(now):
            read = tuple(seen.pressures[i] for i in self._ports)
            if all(map(math.isfinite, read)):
                self._pressures, self._received = read, now
            volts = ZERO
            angles = seen.joints.position
            if self._operator.accepts(stamp, now, "" if all(map(math.isfinite, angles)) else "no reading"):
                tank = seen.of_kind("thermocouple")[0]
                readings = Readings(angles, self._pressures, seen.supply_pressure, tank)
                volts, self._reason = self._operator.step(readings)
            self._commands.send(now, (now, volts))
        late = self._operator.overdue(now, "")
        if now - self._received > STATE_TIMEOUT:
            late = late or f"nothing good on hydraulics/pressures for {STATE_TIMEOUT:g} s"
        self._reason = self._reason or late
        if late:
            self._commands.send(now, (now, ZERO))


def suite_with(machine: Machine, wires: Wires, seed: int) -> Suite:
    """Return a machine's sensors with noise, calibrated, and what the fault does to them."""
    suite = calibrated(sensor_suite(machine, noise=True, seed=seed))
    if not wires.fault.sensors:
        return suite
    until = f" until {wires.ends:g} s" if math.isfinite(wires.ends) else ""
    when = f"from {wires.begins:g} s{until}"
    texts = wires.fault.sensors.format(axis=AXES[wires.axis], cylinder=AXES[1 + wires.axis % 2]).split(";")
    return suite._replace(faults=parse_faults(";".join(f"{text} {when}" for text in texts)))


SCENES: dict[State, Callable[[Machine, State, Wires, int], Scene]] = {
    State.TAUGHT: Taught,
    State.EXPERIMENT: Experiment,
}


def scene(machine: Machine, state: State, wires: Wires, seed: int) -> Scene:
    """Return a crane in a state, with a fault to come."""
    return SCENES.get(state, ByHand)(machine, state, wires, seed)
