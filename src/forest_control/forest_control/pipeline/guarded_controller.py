"""The controller behind its guard: what node and offline loop run when a state of the machine arrives.

joystick, state -> may the crane move? (`motion_permission`) -> may it follow a taught command?
(`taught_watch`) -> `controller` -> command, telemetry
"""

from collections.abc import Callable

from forest_control.config.controller_settings import Parameters
from forest_control.config.parameter_update import ParameterUpdate
from forest_control.operator.taught_command import TaughtCommand
from forest_control.pipeline.control_state import REST, Inputs, State, Telemetry, ValveFeedback, stopped
from forest_control.pipeline.controller import counted_angles, step_with_telemetry
from forest_control.safety import taught_watch
from forest_control.safety.motion_guard import MotionGuard
from forest_control.safety.motion_permission import (
    NOBODY,
    Decision,
    MachineState,
    Override,
    PermissionParameters,
    Verdict,
    reset_sensor_watch,
)
from forest_control.servo.joint_angle_filter import UNREAD, Lengths
from forest_control.valve.tracking_limit import OpeningRatio
from forest_description.geometry.kinematics import tip_position
from forest_description.types import ZERO, Vec3


def control_inputs(
    machine: MachineState, decision: Decision, cylinders: Lengths, opening_ratio: OpeningRatio, voltages: Vec3
) -> Inputs:
    """Return what the controller steps with.

    Args:
        machine: its state, which is believed.
        decision: on it.
        cylinders: lengths [m] of boom and stick, of the same moment; NaN: no sample.
        opening_ratio: of the valves.
        voltages: of the valves, given last [V].
    """
    return Inputs(
        angles=machine.angles,
        rates=machine.rates,
        levers=decision.levers,
        enabled=decision.verdict == Verdict.MOVE,
        speed_scale=decision.speed_scale,
        cylinders=cylinders,
        opening_ratio=opening_ratio,
        voltages=voltages,
        boom_pressures=machine.boom_pressures,
        overloaded=decision.overloaded,
    )


Step = Callable[[State, Inputs, Parameters, float], tuple[State, Telemetry]]


class GuardedController:
    """State of one controller and of its guard.

    Args:
        p: the controller's parameters.
        guard: what a user may set of the guard.
        step: of the controller, interpreted or compiled.
    """

    def __init__(self, p: Parameters, guard: PermissionParameters, step: Step = step_with_telemetry) -> None:
        self.guard, self.command = MotionGuard(guard), ZERO  # [V] of ideal valves, the last one
        self._tuning, self._state, self._step = ParameterUpdate(p), REST, step
        self._taught = taught_watch.REST

    @property
    def parameters(self) -> Parameters:
        """The controller's parameters that are in force."""
        return self._tuning.core

    def moves(self) -> bool:
        """Tell whether somebody drives the crane, or it has not come to rest since."""
        return self.guard.permission.joystick.armed or self.command != ZERO

    def tune(self, p: Parameters) -> None:
        """Follow parameters that were set while the machine may be moving."""
        self._tuning.request(p)

    def hear_taught(self, run: float, command: TaughtCommand, sent: float, problem: str = "") -> None:
        """Hear a taught command of a run, and when it was sent [s]; a problem says why it cannot be read."""
        self._taught = taught_watch.heard(self._taught, run, command, sent, problem)

    def stop(self) -> None:
        """Forget all motion: the command is zero."""
        self._state, self.command = stopped(self._state), ZERO
        self._taught = taught_watch.ended(self._taught)
        self.guard.permission = reset_sensor_watch(self.guard.permission)

    def stops_without_state(self, now: float, override: Override = NOBODY) -> bool:
        """Stop if the machine's state has not come for too long by a time [s]; tell whether that is so."""
        lost = self.guard.is_lost(now, override)
        if lost:
            self.stop()
        return lost

    def advance(
        self,
        machine: MachineState,
        valves: ValveFeedback,
        now: float,
        cylinders: Lengths = UNREAD,
        override: Override = NOBODY,
        problem: str = "",
    ) -> tuple[Decision, Telemetry | None]:
        """Return what follows from a state of the machine; of one that is not believed, no telemetry.

        The caller asks `stops_without_state` before, since after a stall this may come before its watchdog.

        Args:
            machine: its state, just come.
            valves: what the driver reports.
            now: local time [s].
            cylinders: lengths [m] of boom and stick, of the same moment; NaN: no sample.
            override: who else forbids motion.
            problem: why the state cannot be read.
        """
        p, command = self.parameters, self.command
        machine = machine._replace(lengths=cylinders)
        decision = self.guard.decide(machine, valves.driver, command, p, now, override, problem)
        if decision.dt > 0.0 and self._tuning.apply_if_due(command == ZERO, decision.dt):
            self._state = self._state._replace(changed=True)
        if not decision.believed:
            if decision.verdict == Verdict.STOP:
                self.stop()
            return decision, None
        if decision.verdict == Verdict.STOP:
            self._state = stopped(self._state)  # from which there is no ramp: zero at once
        inputs = control_inputs(machine, decision, cylinders, valves.opening_ratio, valves.voltages)
        taught = self._follow(decision, machine.angles, now)
        inputs = inputs._replace(enabled=inputs.enabled and not self._taught.cause, taught=taught)
        self._state, telemetry = self._step(self._state, inputs, self.parameters, decision.dt)
        self.command = telemetry.output.command
        return decision, telemetry

    def _follow(self, decision: Decision, angles: Vec3, now: float) -> TaughtCommand:
        """Return the taught command that counts for measured angles [rad] at a time [s]."""
        p = self.parameters
        guard, tip = self.guard, tip_position(counted_angles(angles, self._state, p), p.links)
        moves, joystick = decision.verdict == Verdict.MOVE, guard.permission.joystick
        self._taught, command = taught_watch.assessed(
            self._taught, moves, joystick, tip, now, guard.p.joystick
        )
        guard.causes["joystick"] = guard.causes["joystick"] or self._taught.cause
        return command
