"""Whether the crane may move: what stops it, how, and why. Node and loops ask here before each step.

Samples come in with the time at which they were received [s, local clock]; a verdict comes out. All of it is
in the subset of Python that `forest_compile` translates; `motion_guard` tells the causes in sentences.

| what happens | found by | verdict |
|---|---|---|
| a state of the machine is older than `state_timeout` when it is read | here | SKIP |
| its stamp stands still or goes back | `stamp_order` | SKIP |
| it comes too soon for a step | `stamped_period` | SKIP |
| no state for `state_timeout` | here, `is_lost` | STOP |
| a state cannot be read, or cannot be true | `state_checks` | STOP |
| a sensor gives the same number while its joint is told to move | `frozen_sensor` | STOP |
| the valve driver is silent, or keeps the valves shut | `driver_response` | STOP |
| another machine than the file tells of: for good | `machine_file_check` | STOP |
| a joint that goes back, or stands, though its valve is open | `overloaded_joint` | STOP |
| a joint that goes by itself under a shut valve | `runaway` | STOP |
| emergency stop; `hands_off` | `Override` | STOP |
| the deadman is not held, the levers were not centred since | `joystick_watch` | CONTROLLED_STOP |
| the joystick is silent, lost, frozen, or cannot be read | `joystick_watch` | CONTROLLED_STOP |
| none of these | | MOVE |

What stops the crane disarms the levers, but for a state that is refused once: they must be centred before
they move it again. Lone refusals do not, or one bad sample of many would throw the operator out. Behind a
fault of sensors or machine, and an overload, the deadman must be let go: sticks that are centred, as in
taught work, are no act of a person.
"""

import math
from enum import IntEnum
from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_control.limits.load_weighing import UNREAD, Pressures
from forest_control.operator import joystick_watch
from forest_control.operator.joystick_interpolation import CENTRED, InterpolatedLevers, interpolated
from forest_control.operator.joystick_watch import Sample, Watch, WatchParameters, assessed_watch
from forest_control.operator.late_link import IN_TIME, LateLink, speed_scale, updated_link
from forest_control.operator.levers import REST, Levers
from forest_control.safety import (
    driver_response,
    frozen_sensor,
    machine_file_check,
    overloaded_joint,
    runaway,
)
from forest_control.safety.driver_response import DriverResponse, DriverSample
from forest_control.safety.frozen_sensor import Stillness
from forest_control.safety.machine_file_check import FileCheck
from forest_control.safety.overloaded_joint import Overload
from forest_control.safety.runaway import Runaway
from forest_control.safety.state_checks import jumps, plausible
from forest_control.servo.joint_angle_filter import UNREAD as NO_LENGTHS
from forest_control.servo.joint_angle_filter import Lengths
from forest_description.types import ZERO, Vec3
from forest_msgs_py.runtime import stamp_order, stamped_period
from forest_msgs_py.runtime.stamp_order import StampOrder
from forest_msgs_py.runtime.stamped_period import StampedPeriod
from forest_msgs_py.types import PERIOD


class Verdict(IntEnum):
    """What the controller may do."""

    SKIP = 0  # the sample counts for nothing; what was decided before stands
    STOP = 1  # zero voltage at once
    CONTROLLED_STOP = 2  # the tip stops along its path; then it is held
    MOVE = 3  # the levers move the crane


class Cause(IntEnum):
    """Why the crane may not move."""

    NONE = 0
    LEFT_OVER = 1  # a state from before a stall, ours or the machine's
    UNBELIEVABLE = 2  # a state that cannot be read, or cannot be true
    DISORDER = 3  # a state whose stamp stands still or goes back
    TOO_SOON = 4  # a state too soon for a step
    FAULT = 5  # of sensors, driver or machine file, or a joint that moves by itself
    EMERGENCY_STOP = 6
    HANDS_OFF = 7
    OPERATOR = 8  # the joystick, or the deadman is not held
    OVERLOAD = 9  # a load, or what a joint has met, drives it back or holds it


class Decision(NamedTuple):
    """What follows from a state of the machine."""

    verdict: Verdict
    cause: Cause
    believed: bool = False  # the controller may go by the state; if stopped, from rest
    levers: Levers = REST
    dt: float = 0.0  # [s] since the state before; 0: the state counts for nothing
    overloaded: bool = False  # a joint went back, or stood; until the levers are armed anew
    speed_scale: float = 1.0  # of the levers, behind a late link


class MachineState(NamedTuple):
    """A sample of the joints."""

    angles: Vec3  # [rad]
    rates: Vec3  # [rad/s]
    stamp: int  # [ns]
    received: float  # [s]
    readable: bool = True
    boom_pressures: Pressures = UNREAD  # [Pa] of its cylinder, head and rod side; NaN: no sample
    lengths: Lengths = NO_LENGTHS  # [m] of the cylinders of boom and stick; NaN: no sample
    supply: float = math.nan  # [Pa] of the pump; NaN: no sample


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
    """What the checks of sensors, driver, machine file and joints remember."""

    still: Stillness = frozen_sensor.MOVING
    driver: DriverResponse = DriverResponse()
    overload: Overload = Overload()
    file: FileCheck = FileCheck()
    last_overload: Overload = Overload()  # as it stopped the crane; kept until the levers move it anew
    let_go: bool = True  # the deadman was released since that, or a fault
    runaway: Runaway = Runaway()


class Permission(NamedTuple):
    """What is remembered for one controller."""

    joystick: Watch = joystick_watch.REST
    interpolation: InterpolatedLevers = CENTRED
    checks: Checks = Checks()
    order: StampOrder = stamp_order.FIRST
    period: StampedPeriod = stamped_period.BEGIN  # of the states that are believed
    received: float = -math.inf  # [s] when a state was believed last
    angles: Vec3 = ZERO  # [rad] of that
    refused: float = 0.0  # [s] after that, a jump was refused last
    link: LateLink = IN_TIME


def updated_joystick(before: Permission, sample: Sample) -> Permission:
    """Take in one sample of the joystick, oldest first."""
    return before._replace(joystick=joystick_watch.updated_watch(before.joystick, sample))


def is_state_lost(permission: Permission, now: float, guard: PermissionParameters) -> bool:
    """Tell whether states came, and none was believed for longer than `state_timeout`; the caller disarms."""
    return permission.period.started and now - permission.received > guard.state_timeout


def disarmed(before: Permission, now: float, guard: PermissionParameters) -> Permission:
    """Judge the joystick at a time [s] when the machine must not move, whatever it says."""
    joystick, _ = assessed_watch(before.joystick, now, False, guard.joystick)
    return before._replace(joystick=joystick, interpolation=CENTRED)


def reset_sensor_watch(before: Permission) -> Permission:
    """Begin the watch over the sensors anew: the crane was stopped."""
    return before._replace(checks=before.checks._replace(still=frozen_sensor.MOVING))


def decide(
    before: Permission,
    state: MachineState,
    driver: DriverSample,
    command: Vec3,
    p: Parameters,
    guard: PermissionParameters,
    now: float,
    override: Override,
) -> tuple[Permission, Decision]:
    """Return what follows from a state of the machine, and what is remembered.

    Args:
        before: what was.
        state: just come.
        driver: its newest voltages.
        command: of ideal valves, the last one [V].
        p: the controller's parameters.
        guard: what is set of the guard.
        now: local time [s].
        override: who else forbids motion.
    """
    if now - state.received > guard.state_timeout:
        return before, Decision(Verdict.SKIP, Cause.LEFT_OVER)
    if not state.readable or not plausible(state.angles, state.rates, p):
        return before, Decision(Verdict.STOP, Cause.UNBELIEVABLE)
    order = stamp_order.updated_order(before.order, state.stamp, state.received, guard.state_timeout)
    if not stamp_order.is_in_order(before.order, state.stamp):
        return before._replace(order=order), Decision(Verdict.SKIP, Cause.DISORDER)
    if state.received - before.received <= guard.state_timeout and jumps(
        before.angles, state.angles, unseen(before, state, guard)
    ):
        return before._replace(refused=since(before, state)), Decision(Verdict.STOP, Cause.UNBELIEVABLE)
    period, dt = stamped_period.step_period(before.period, state.stamp, state.received, guard.period)
    after = before._replace(order=order, period=period, received=state.received)
    after = after._replace(angles=state.angles, refused=0.0)
    if dt == 0.0:
        return after, Decision(Verdict.SKIP, Cause.TOO_SOON)
    checks = updated_checks(before.checks, state, driver, command, p, guard, now, dt)
    link = updated_link(before.link, before.joystick.stamp, state.stamp, dt)
    return decide_by_checks(after._replace(checks=checks, link=link), now, dt, guard, override)


def since(before: Permission, state: MachineState) -> float:
    """Return the time [s] since a state was believed last, by clock or stamps."""
    return max(state.received - before.received, 1e-9 * (state.stamp - before.order.newest))


def unseen(before: Permission, state: MachineState, guard: PermissionParameters) -> float:
    """Return the time [s] in which joints were not seen, a period at the least: what jumped stays refused."""
    return max(guard.period, since(before, state) - before.refused)


def decide_by_checks(
    before: Permission, now: float, dt: float, guard: PermissionParameters, override: Override
) -> tuple[Permission, Decision]:
    """Return the decision on a state that can be true, dt [s] after the one before."""
    checks = before.checks
    if not checks_pass(checks, now):
        faulty = before._replace(checks=checks._replace(let_go=checks.let_go and machine_is_sound(checks)))
        return disarmed(faulty, now, guard), Decision(Verdict.STOP, Cause.FAULT, dt=dt)
    if overloaded_joint.is_overloaded(checks.overload):
        sunk = checks._replace(overload=Overload(), last_overload=checks.overload, let_go=False)
        stop = Decision(Verdict.STOP, Cause.OVERLOAD, believed=True, dt=dt, overloaded=True)
        return disarmed(before._replace(checks=sunk), now, guard), stop
    let_go = checks.let_go or not before.joystick.held
    after, decision = decide_by_operator(
        before._replace(checks=checks._replace(let_go=let_go)), now, dt, guard, override
    )
    overloaded = overloaded_joint.is_overloaded(checks.last_overload)
    if decision.verdict == Verdict.MOVE and not let_go:
        cause = Cause.OVERLOAD if overloaded else Cause.OPERATOR
        waiting = Decision(Verdict.CONTROLLED_STOP, cause, believed=True, dt=dt, overloaded=overloaded)
        return disarmed(after, now, guard), waiting
    if decision.verdict == Verdict.MOVE:
        return after._replace(checks=after.checks._replace(last_overload=Overload())), decision
    return after, decision._replace(overloaded=overloaded)


def decide_by_operator(
    before: Permission, now: float, dt: float, guard: PermissionParameters, override: Override
) -> tuple[Permission, Decision]:
    """Return the decision on a state that is believed: the operator's, if nobody else forbids it."""
    if override.emergency_stop or override.hands_off:
        cause = Cause.EMERGENCY_STOP if override.emergency_stop else Cause.HANDS_OFF
        return disarmed(before, now, guard), Decision(Verdict.STOP, cause, believed=True, dt=dt)
    joystick, operator = assessed_watch(before.joystick, now, True, guard.joystick)
    if not operator.enabled:
        after = before._replace(joystick=joystick, interpolation=CENTRED)
        return after, Decision(Verdict.CONTROLLED_STOP, Cause.OPERATOR, believed=True, dt=dt)
    interpolation = interpolated(
        before.interpolation, operator.levers, joystick.fresh_since, before.received, dt
    )
    after = before._replace(joystick=joystick, interpolation=interpolation)
    scale = speed_scale(before.link)
    return after, Decision(
        Verdict.MOVE, Cause.NONE, believed=True, levers=interpolation.levers, speed_scale=scale, dt=dt
    )


def updated_checks(
    before: Checks,
    state: MachineState,
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
        state: the sample.
        driver: its newest voltages.
        command: of ideal valves, since the last sample [V].
        p: the controller's parameters.
        guard: what is set of the guard.
        now: local time [s].
        dt: since the last sample [s].
    """
    still = before.still
    if not guard.noise_free:
        still = frozen_sensor.updated_stillness(before.still, state.angles, command, p, dt)
    u = overloaded_joint.commanded_rates(state.angles, command, p)
    overload = overloaded_joint.updated_overload(
        before.overload, u, state.rates, driver.voltages, state.boom_pressures, p, dt
    )
    by_itself = before.runaway
    if driver.received > -math.inf:  # of a driver that has never spoken no valve is known to be shut
        by_itself = runaway.updated_runaway(before.runaway, state.rates, driver.voltages, p, dt)
    return Checks(
        still=still,
        driver=driver_response.response(before.driver, driver, command, now),
        overload=overload,
        file=machine_file_check.updated_check(
            before.file,
            state.angles,
            state.rates,
            state.lengths,
            u,
            driver.voltages,
            overload,
            state.boom_pressures,
            state.supply,
            p,
            dt,
        ),
        last_overload=before.last_overload,
        let_go=before.let_go,
        runaway=by_itself,
    )


def checks_pass(checks: Checks, now: float) -> bool:
    """Tell whether sensors, driver and machine are what the controller goes by."""
    return machine_is_sound(checks) and driver_response.responds(checks.driver, now)


def machine_is_sound(checks: Checks) -> bool:
    """Tell whether sensors and machine are what the controller goes by."""
    if machine_file_check.is_wrong(checks.file) or runaway.runs_away(checks.runaway):
        return False
    return not frozen_sensor.is_frozen(checks.still)


def armed_watch() -> Watch:
    """Return the watch over a joystick whose deadman is held with centred levers: a loop begins so."""
    heard = Sample(
        received=-PERIOD,
        stamp=joystick_watch.NO_STAMP,
        heartbeat=0,
        same=False,
        good=True,
        levers=REST,
        held=True,
    )
    watch, _ = assessed_watch(
        joystick_watch.updated_watch(joystick_watch.REST, heard), -PERIOD, True, WatchParameters()
    )
    return watch
