"""The closed loop of the real cores, the driver's gate included, with a fault in one of its wires.

Its joystick is a device without heartbeat, whose converter has noise, and that has shown so.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from forest_control.config import controller_settings
from forest_control.operator.joystick_watch import NO_HEARTBEAT, Sample
from forest_control.operator.levers import REST, Levers
from forest_control.pipeline.controller_topics import load_caution
from forest_control.pipeline.guarded_controller import GuardedController
from forest_control.safety.motion_permission import Permission, armed_watch
from forest_control.valve import valve_driver, valve_driver_parameters
from forest_control.valve.command_gate import Command, CommandGate, Verdict
from forest_description.types import ZERO, Vec3
from forest_msgs_py.types import PERIOD, PERIOD_NS
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.sensors.sensor_readings import NOMINAL
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.sensors.signal_processing import Measurement
from forest_study.closed_loop.closed_loop import COMMAND_TIMEOUT, ClosedLoop, Joystick, Operator
from forest_study.closed_loop.loop_core import Happened
from forest_study.faults.fault import Fault, Moment

RESTLESS = 45.0  # [s] of play in which the device was never still: that it hangs is seen after 0.5 s
NOISE = 1e-6  # [1] of a lever in play
NO_COMMAND = "no command"  # as the driver's node says


class Wires:
    """A fault in time.

    Args:
        fault: what is wrong.
        axis: that is hit.
        begins: when [s].
        seed: of its chance.
    """

    def __init__(self, fault: Fault, axis: int, begins: float, seed: int) -> None:
        self.fault, self.axis, self.begins, self.seed = fault, axis, begins, seed
        self.ends = math.inf if fault.for_good else begins + fault.lasts
        self._chance = np.random.default_rng([seed, 9])
        self._last: dict[str, Any] = {}  # what passed a wire before the fault

    def later(self, time: float) -> "Wires":
        """Return the same fault, later by a time [s]."""
        return Wires(self.fault, self.axis, self.begins + time, self.seed)

    def act(self, now: float) -> bool:
        """Tell whether the fault acts at a time [s]."""
        return self.begins - 0.5 * PERIOD <= now < self.ends - 0.5 * PERIOD

    def moment(self, wire: str, now: float, what: Any) -> Moment | None:
        """Return the fault's moment at a time [s] when something passes a wire, or None: it is well."""
        if not self.act(now):
            self._last[wire] = what
            return None
        since, chance = PERIOD * round((now - self.begins) / PERIOD), float(self._chance.random())
        return Moment(since, self.axis, self._last.setdefault(wire, what), chance)


class FaultyLoop(ClosedLoop):
    """A closed loop in which something goes wrong.

    Args:
        wires: with the fault.
        p: as all that follows, of `ClosedLoop`.
        control: of it.
        drive: of it.
        start: of it.
        suite: of it.
    """

    def __init__(
        self,
        wires: Wires,
        p: PlantParameters,
        control: controller_settings.Parameters,
        drive: valve_driver_parameters.Parameters,
        start: Vec3,
        suite: Suite,
    ) -> None:
        super().__init__(p, control, drive, start, suite, fast=True)
        self._wires, self._broken, self._well = wires, False, p
        watch = armed_watch()._replace(restless=RESTLESS)
        self.controller.guard.permission = Permission(joystick=watch)
        self._gate = CommandGate(COMMAND_TIMEOUT, lambda: self.now)
        self._before, self._shaking = (REST, True), np.random.default_rng(7)

    @property
    def now(self) -> float:
        """The time [s]."""
        return self._count * PERIOD

    def told(self) -> str:
        """Return what /diagnostics tells the operator, or ""."""
        caution = load_caution(self.telemetry.output.loading) if self.telemetry else ""
        told = *self.controller.guard.causes.values(), self._driver_says(), caution
        return next((text for text in told if text), "")

    def _driver_says(self) -> str:
        lost = NO_COMMAND if self._gate.is_lost() and self._count else ""
        return self._gate.problem or lost or valve_driver.objection(self._driver)

    def period(self, joystick: Joystick) -> Happened:
        """Return what happened in a period."""
        if self._wires.act(self.now) != self._broken:
            self._broken = not self._broken
            if self._broken:
                self._break(self._wires.fault)
            else:
                self._set_plant(self._well)
        return super().period(self._samples(joystick) if isinstance(joystick, Operator) else joystick)

    def _break(self, fault: Fault) -> None:
        if fault.breaks:
            self._simulation, broken = fault.breaks(self._simulation, self._plant)
            self._set_plant(broken)
        if fault.restarts:
            old = self.controller
            self.controller = GuardedController(old.parameters, old.guard.p, self._step)

    def _set_plant(self, plant: PlantParameters) -> None:
        self._plant = plant
        self._sensors.set_plant(plant, NOMINAL)

    def _samples(self, operator: Operator) -> Sequence[Sample]:
        levers, fault = operator.levers, self._wires.fault
        if levers != REST:
            swing, boom, stick = self._shaking.normal(scale=NOISE, size=3).tolist()
            levers = Levers(levers.swing + swing, levers.boom + boom, levers.stick + stick)
        sample = Sample(
            received=self.now,
            stamp=(self._count + 1) * PERIOD_NS,
            heartbeat=NO_HEARTBEAT,
            same=(levers, operator.enabled) == self._before,
            good=True,
            levers=levers,
            held=operator.enabled,
        )
        self._before = levers, operator.enabled
        moment = self._wires.moment("joystick", self.now, sample)
        return fault.joystick(moment, sample) if moment and fault.joystick else (sample,)

    def _sense(self) -> Measurement:
        seen = super()._sense()
        moment = self._wires.moment("seen", self.now, seen)
        return self._wires.fault.seen(moment, seen) if moment else seen

    def _report(self, stamp: int, seen: Measurement, now: float) -> None:
        if moment := self._wires.moment("stamp", self.now, stamp):
            if self._wires.fault.state_lost(moment):
                return
            stamp = self._wires.fault.stamp(moment, stamp)
        super()._report(stamp, seen, now)

    def _command(self, now: float) -> Vec3:
        for sent, values in self._commands.arrived(now):
            said = Command(values, (self._count + 1) * PERIOD_NS, sent)
            moment = self._wires.moment("command", now, said)
            given = self._wires.fault.command(moment, said) if moment else said
            if given is None:
                continue
            verdict = self._gate.decide(given, False)
            if verdict == Verdict.STEP:
                self._newest = sent, given.values
            elif verdict == Verdict.CENTRE:
                self._newest = sent, ZERO
        if self._gate.is_lost():
            self._newest = now, ZERO
        if self._newest[1] == ZERO and (self._gate.problem or self._gate.is_lost()):
            self._driver = valve_driver.at_rest(self._driver)
        return self._newest[1]

    def _move(self, volts: Vec3) -> None:
        moment = self._wires.moment("volts", self.now, volts)
        super()._move(self._wires.fault.volts(moment, volts) if moment else volts)
