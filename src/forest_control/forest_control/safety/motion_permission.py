"""Whether the crane may move: what stops it, how, and why. Node and offline loop ask here before each step.

Samples come in with the time at which they were received [s, local clock]; a verdict comes out.

| what happens | found by | verdict |
|---|---|---|
| a state of the machine is older than `state_timeout` when it is read | here | SKIP |
| its stamp stands still or goes back | `StampOrder` | SKIP |
| it comes too soon for a step | `StampedPeriod` | SKIP |
| no state for `state_timeout` | here, `is_lost` | STOP |
| a state cannot be read, or cannot be true | `state_checks` | STOP |
| a sensor gives the same number while its joint is told to move | `frozen_sensor` | STOP |
| the valve driver is silent, or keeps the valves shut | `driver_response` | STOP |
| emergency stop; `hands_off` | `Override` | STOP |
| the deadman is not held, the levers were not centred since | `joystick_watch` | HOLD |
| the joystick is silent, lost, frozen, or cannot be read | `joystick_watch` | HOLD |
| none of these | | MOVE |

What stops the crane disarms the levers, but for a state that is refused once: they must be centred before
they move it again. Lone refusals do not, or one bad sample of many would throw the operator out.
"""

import math
from enum import IntEnum
from typing import Any, NamedTuple

from forest_control.config.settings import Parameters
from forest_control.operator import joystick_interpolation, joystick_watch
from forest_control.operator.joystick_watch import (
    Joystick,
    Operator,
    Sample,
    Watch,
    WatchParameters,
    is_released,
    problem_text,
)
from forest_control.operator.levers import REST as CENTRED
from forest_control.operator.levers import Levers
from forest_control.safety import driver_response, frozen_sensor
from forest_control.safety.driver_response import DriverResponse, DriverSample
from forest_control.safety.frozen_sensor import Stillness
from forest_control.safety.state_checks import implausible
from forest_description.types import Vec3
from forest_msgs_py.runtime.stamp_order import StampOrder
from forest_msgs_py.runtime.stamped_period import StampedPeriod
from forest_msgs_py.types import PERIOD

GOES_BACK = "joy: a stamp goes back; allowed: rising stamps, or none"
LOST_STATE = "no state of the machine"
PRESSED = "emergency stop pressed"


class Verdict(IntEnum):
    """What the controller may do."""

    SKIP = 0  # the sample counts for nothing; what was decided before stands
    STOP = 1  # zero spool at once
    HOLD = 2  # the tip stops along its path, and is held
    MOVE = 3  # the levers move the crane


class Decision(NamedTuple):
    """What follows from a state of the machine."""

    verdict: Verdict
    cause: str = ""  # in one sentence; "": none, or the deadman is released
    believed: bool = False  # the controller may go by the state; if stopped, from rest
    levers: Levers = CENTRED
    dt: float = 0.0  # [s] since the state before; 0: the state counts for nothing


class MachineState(NamedTuple):
    """A sample of the joints."""

    angles: Vec3  # [rad]
    rates: Vec3  # [rad/s]
    stamp: int  # [ns]
    received: float  # [s]
    problem: str = ""  # why it cannot be read


class Override(NamedTuple):
    """Who else forbids motion."""

    emergency_stop: bool = False
    hands_off: bool = False  # somebody else has the valves


NOBODY = Override()


class PermissionParameters(NamedTuple):
    """What a user may set."""

    joystick: WatchParameters = WatchParameters()
    state_timeout: float = 0.1  # [s]
    period: float = PERIOD  # nominal, of the state [s]
    noise_free: bool = False  # simulated sensors: a joint that stands still gives the same number again


class Checks(NamedTuple):
    """What the checks of sensors and driver remember."""

    still: Stillness = frozen_sensor.MOVING
    driver: DriverResponse = DriverResponse()


def checked(
    before: Checks,
    s: Vec3,
    driver: DriverSample,
    command: Vec3,
    p: Parameters,
    guard: PermissionParameters,
    now: float,
    dt: float,
) -> Checks:
    """Return the checks after a sample.

    Args:
        before: as they were.
        s: measured angles [rad].
        driver: its newest voltages.
        command: of ideal valves, since the last sample [V].
        p: the controller's parameters.
        guard: what is set of the guard.
        now: local time [s].
        dt: since the last sample [s].
    """
    return Checks(
        still=before.still if guard.noise_free else frozen_sensor.watched(before.still, s, command, p, dt),
        driver=driver_response.response(before.driver, driver, command, now),
    )


def passes(checks: Checks, now: float) -> bool:
    """Tell whether sensors and driver do what the controller goes by; `fault` says what does not."""
    return driver_response.responds(checks.driver, now) and not frozen_sensor.is_frozen(checks.still)


def fault(checks: Checks, now: float) -> str:
    """Return what is wrong with driver or sensors, or ""."""
    return driver_response.objection(checks.driver, now) or frozen_sensor.frozen(checks.still)


class MotionPermission:
    """Decides for one controller.

    Args:
        p: what a user may set.
    """

    def __init__(self, p: PermissionParameters) -> None:
        self.p = p
        self.joystick = joystick_watch.REST
        self.causes = {"joystick": "", "machine": "", "emergency stop": ""}  # of trouble, by what is unwell
        self._hold = joystick_interpolation.CENTRED
        self._unreadable = ""  # the last sample of the joystick, and why
        self._checks = Checks()
        self._order, self._period = StampOrder(p.state_timeout), StampedPeriod(p.period)
        self._state_received = -math.inf
        self._refused = -math.inf, ""  # when a state was last not believed, and why

    def hear(self, sample: Sample, problem: str = "") -> None:
        """Take in one sample of the joystick, oldest first; `problem` says why it cannot be read."""
        dropped = self.joystick.out_of_order
        self.joystick = joystick_watch.updated_watch(self.joystick, sample)
        in_order = self.joystick.out_of_order == dropped
        self._unreadable = problem or ("" if in_order else GOES_BACK)

    def is_lost(self, now: float, override: Override) -> bool:
        """Tell whether the machine's state came, and then not for too long, which disarms the levers."""
        if not self.has_begun() or now - self._state_received <= self.p.state_timeout:
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
    ) -> Decision:
        """Return what follows from a state of the machine.

        Args:
            state: just come.
            driver: its newest voltages.
            command: of ideal valves, the last one [V].
            p: the controller's parameters.
            now: local time [s].
            override: who else forbids motion.
        """
        if now - state.received > self.p.state_timeout:
            return Decision(Verdict.SKIP, LOST_STATE)  # left over from a stall, ours or the machine's
        problem = state.problem or implausible(state.angles, state.rates, p)
        if problem:
            return self._refuse(Verdict.STOP, problem, now)
        disorder = self._order.problem("joint state", state.stamp, state.received)
        if disorder:
            return self._refuse(Verdict.SKIP, disorder, now)
        self._state_received = state.received
        dt = self._period.step(state.stamp, state.received)
        if dt == 0.0:
            return Decision(Verdict.SKIP, "joint state: too soon for a step")
        self._checks = checked(self._checks, state.angles, driver, command, p, self.p, now, dt)
        self.causes["machine"] = fault(self._checks, now)
        if self.causes["machine"]:
            self.disarm(now, override)
            return Decision(Verdict.STOP, self.causes["machine"], dt=dt)
        return self._permit(state, now, dt, override)

    def forget(self) -> None:
        """Begin the watch over the sensors anew: the crane was stopped."""
        self._checks = self._checks._replace(still=frozen_sensor.MOVING)

    def disarm(self, now: float, override: Override) -> None:
        """Judge the joystick at a time [s] when the machine must not move, whatever it says."""
        self._judge(now, False, override)

    def is_nobody_there(self) -> bool:
        """Tell whether there never was a joystick, or it went after the deadman was released."""
        watch = self.joystick
        return watch.joystick == Joystick.SILENT or (watch.joystick == Joystick.LOST and not watch.held)

    def against_reset(self) -> str:
        """Return what stands against a reset of the emergency stop, or ""."""
        released = is_released(self.joystick, self.p.joystick.centre)
        return "" if released else "the levers must be centred and the deadman released"

    def joystick_values(self) -> dict[str, Any]:
        """Return what is known of the joystick, by names with units, for /diagnostics."""
        watch, p = self.joystick, self.p.joystick
        return {
            "state": Joystick(watch.joystick).name.lower(),
            "deadman held": watch.held,
            "armed": watch.armed,
            "joy_timeout [s]": p.joy_timeout,
            "frozen_timeout [s]": p.frozen_timeout,
            "centre [1]": p.centre,
            "out of order since start": watch.out_of_order,
        }

    def has_begun(self) -> bool:
        """Tell whether a state has ever been used."""
        return self._period.started

    def _refuse(self, verdict: Verdict, problem: str, now: float) -> Decision:
        """Remember and tell why a state of the machine is not believed."""
        self._refused, self.causes["machine"] = (now, problem), problem
        return Decision(verdict, problem)

    def _permit(self, state: MachineState, now: float, dt: float, override: Override) -> Decision:
        """Return the decision on a state that is believed: the operator's, if nobody else forbids it."""
        forbidden = PRESSED if override.emergency_stop else "hands off" if override.hands_off else ""
        operator = self._judge(now, not forbidden, override)
        if forbidden:
            return Decision(Verdict.STOP, forbidden, believed=True, dt=dt)
        if not operator.enabled:
            return Decision(Verdict.HOLD, self.causes["joystick"], believed=True, dt=dt)
        said = self.joystick.fresh_since
        self._hold = joystick_interpolation.interpolated(
            self._hold, operator.levers, said, state.received, dt
        )
        return Decision(Verdict.MOVE, believed=True, levers=self._hold.levers, dt=dt)

    def _judge(self, now: float, allowed: bool, override: Override) -> Operator:
        """Return where the levers are, and whether they may move anything."""
        self.joystick, operator = joystick_watch.assessed_watch(self.joystick, now, allowed, self.p.joystick)
        # A joystick that goes after the deadman was released is not missed.
        gone = "" if self.is_nobody_there() else problem_text(self.joystick)
        self.causes["joystick"] = self._unreadable or gone
        self.causes["emergency stop"] = PRESSED if override.emergency_stop else ""
        if not operator.enabled:
            self._hold = joystick_interpolation.CENTRED
        return operator


def armed_watch() -> Watch:
    """Return the watch over a joystick whose deadman is held with centred levers: a loop begins so."""
    heard = Sample(
        received=-PERIOD,
        stamp=joystick_watch.NO_STAMP,
        heartbeat=0,
        same=False,
        good=True,
        levers=CENTRED,
        held=True,
    )
    watch, _ = joystick_watch.assessed_watch(
        joystick_watch.updated_watch(joystick_watch.REST, heard), -PERIOD, True, WatchParameters()
    )
    return watch
