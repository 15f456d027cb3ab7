"""The guard of one controller: what `motion_permission` remembers, and its causes in sentences.

/diagnostics tells a cause for each of three parts: joystick, machine, emergency stop.
"""

import math
from typing import Any

from forest_control.config.controller_settings import Parameters
from forest_control.operator import late_link
from forest_control.operator.joystick_watch import (
    Joystick,
    Sample,
    is_deflected_unarmed,
    is_released,
    problem_text,
)
from forest_control.safety import (
    driver_response,
    frozen_sensor,
    machine_file_check,
    motion_permission,
    overloaded_joint,
    runaway,
)
from forest_control.safety.driver_response import DriverSample
from forest_control.safety.motion_permission import (
    Cause,
    Decision,
    MachineState,
    Override,
    Permission,
    PermissionParameters,
)
from forest_control.safety.state_checks import implausible, jump
from forest_description.types import Vec3
from forest_msgs_py.runtime.stamp_order import disorder

GOES_BACK = "joy: a stamp goes back; allowed: rising stamps, or none"
LOST_STATE = "no state of the machine"
PRESSED = "emergency stop pressed"
WAS_FAULTY = "machine: a fault is over; allowed: release the deadman"
NOT_CENTRED = "joystick: the levers move nothing until they have been centred"
MISSED = 1.0  # [s] without a sample of /joy, after which people are told that one is waited for


class MotionGuard:
    """Decides for one controller.

    Args:
        p: what a user may set.
    """

    def __init__(self, p: PermissionParameters) -> None:
        self.p, self.permission = p, Permission()
        self.causes = {"joystick": "", "machine": "", "emergency stop": ""}  # of trouble, by what is unwell
        self._unreadable = ""  # the last sample of the joystick, and why
        self._refused = -math.inf, ""  # when a state was last not believed, and why

    def hear(self, sample: Sample, problem: str = "") -> None:
        """Take in one sample of the joystick, oldest first; `problem` says why it cannot be read."""
        dropped = self.permission.joystick.out_of_order
        self.permission = motion_permission.updated_joystick(self.permission, sample)
        in_order = self.permission.joystick.out_of_order == dropped
        self._unreadable = problem or ("" if in_order else GOES_BACK)

    def is_lost(self, now: float, override: Override) -> bool:
        """Tell whether states came, and none was believed for too long, which disarms the levers."""
        if not motion_permission.is_state_lost(self.permission, now, self.p):
            return False
        self.disarm(now, override)
        when, why = self._refused  # the cause, rather than what follows from it
        self.causes["machine"] = why if now - when <= self.p.state_timeout else LOST_STATE
        return True

    def decide(
        self,
        state: MachineState,
        driver: DriverSample,
        command: Vec3,
        p: Parameters,
        now: float,
        override: Override,
        problem: str = "",
    ) -> Decision:
        """Return what follows from a state of the machine.

        Args:
            state: just come.
            driver: its newest voltages.
            command: of ideal valves, the last one [V].
            p: the controller's parameters.
            now: local time [s].
            override: who else forbids motion.
            problem: why the state cannot be read.
        """
        before, order = self.permission, self.permission.order
        self.permission, decision = motion_permission.decide(
            self.permission, state, driver, command, p, self.p, now, override
        )
        if decision.cause == Cause.UNBELIEVABLE:
            untrue = problem or implausible(state.angles, state.rates, p)
            seconds = motion_permission.unseen(before, state, self.p)
            self._refuse(untrue or jump(before.angles, state.angles, seconds), now)
        elif decision.cause == Cause.DISORDER:
            self._refuse(disorder(order, "joint state", state.stamp), now)
        elif decision.dt > 0.0:
            checks = self.permission.checks
            trouble = machine_file_check.objection(checks.file) or driver_response.objection(
                checks.driver, now
            )
            trouble = trouble or frozen_sensor.frozen(checks.still) or runaway.objection(checks.runaway)
            trouble = trouble or overloaded_joint.objection(checks.last_overload)
            self.causes["machine"] = trouble or ("" if checks.let_go else WAS_FAULTY)
            self._note_operator(override)
        return decision

    def disarm(self, now: float, override: Override) -> None:
        """Judge the joystick at a time [s] when the machine must not move, whatever it says."""
        self.permission = motion_permission.disarmed(self.permission, now, self.p)
        self._note_operator(override)

    def has_begun(self) -> bool:
        """Tell whether a state has ever been used."""
        return self.permission.period.started

    def is_nobody_there(self) -> bool:
        """Tell whether there never was a joystick, or it went after the deadman was released."""
        watch = self.permission.joystick
        return watch.joystick == Joystick.SILENT or (watch.joystick == Joystick.LOST and not watch.held)

    def misses_joystick(self, age: float) -> bool:
        """Tell whether a joystick is waited for, by the age of the newest sample [s]; inf: there was none.

        One that goes on sending is there, though a hand behind it may be late for some tenths of a second.
        """
        return self.is_nobody_there() and age > MISSED

    def against_reset(self) -> str:
        """Return what stands against a reset of the emergency stop, or ""."""
        released = is_released(self.permission.joystick, self.p.joystick.centre)
        return "" if released else "the levers must be centred and the deadman released"

    def joystick_caution(self) -> str:
        """Return why a joystick that is well moves nothing though its deadman is held, or "".

        While the emergency stop is pressed, that is why.
        """
        deflected = is_deflected_unarmed(self.permission.joystick, self.p.joystick.centre)
        return NOT_CENTRED if deflected and not self.causes["emergency stop"] else ""

    def joystick_values(self) -> dict[str, Any]:
        """Return what is known of the joystick, by names with units, for /diagnostics."""
        watch, p = self.permission.joystick, self.p.joystick
        return {
            "state": Joystick(watch.joystick).name.lower(),
            "deadman held": watch.held,
            "armed": watch.armed,
            "joy_timeout [s]": p.joy_timeout,
            "frozen_timeout [s]": p.frozen_timeout,
            "centre [1]": p.centre,
            "out of order since start": watch.out_of_order,
            "round trip by its stamps [s]": late_link.round_trip(self.permission.link),
        }

    def _refuse(self, problem: str, now: float) -> None:
        """Remember why a state of the machine is not believed."""
        self._refused, self.causes["machine"] = (now, problem), problem

    def _note_operator(self, override: Override) -> None:
        """Tell what is wrong with the joystick as it was just judged, and who pressed the stop."""
        # A joystick that goes after the deadman was released is not missed.
        gone = "" if self.is_nobody_there() else problem_text(self.permission.joystick)
        self.causes["joystick"] = self._unreadable or gone
        self.causes["emergency stop"] = PRESSED if override.emergency_stop else ""
