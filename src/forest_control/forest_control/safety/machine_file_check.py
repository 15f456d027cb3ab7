"""Whether the machine is the one that the controller's machine file tells of: what it does first shows that.

Three things are asked of it:

- The lengths of boom's and stick's cylinder, where they are measured, belong to the measured angles.
- Each joint goes where its valve is commanded, once.
- Each joint goes about as fast, and the boom carries its own weight (`machine_answers`), once.

What has answered right is not asked again: later a broken sensor or a load is to blame. But lengths that are
off by less than a broken transducer's are asked for ever, for a pin that is elsewhere shows in other poses.
Lengths that once fitted stop the crane while they do not: a transducer that hung may be to blame. What else
answers wrong stops the crane for good: with another geometry, or a valve that is piped or wired the other
way, no motion is what its command says. Then the file is to be set right, and the controller started anew.

A boom that goes back before it has proven right may also carry too much: then its pressure is the pump's or
more, while oil that is led to the other side leaves it to its weight. Such a way does not count
(`overloaded_joint` names it).

What is judged while the pump gives less than it keeps at idle is the pump's, or of a file with another pump:
without oil a joint sinks, whatever is commanded.

| symbol | name | unit |
|---|---|---|
| u, v | commanded and measured joint rate | rad/s |
| way | what a joint has gone to the side of u, since that last changed: integral of v sgn(u) | rad |

A way ends where the command turns round. Oil and spool lag behind levers that tremble, and a joint that rocks
against them as they turn has gone nowhere.

Not seen: wrong lengths of links, masses and gains that are less than twice off; and a wrong geometry, where
neither cylinders nor pressures are measured, that makes joints neither far slower nor faster.
"""

import math
from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_control.limits.load_weighing import Pressures
from forest_control.safety import machine_answers, overloaded_joint
from forest_control.safety.machine_answers import FASTEST, NO_ANSWERS, Answers
from forest_control.safety.overloaded_joint import BORNE, Overload, is_fed, opens
from forest_control.servo.joint_angle_filter import FARTHEST, Lengths
from forest_description.geometry.linkage import angle_at
from forest_description.types import AXES, ZERO, Vec3

PROVEN = 0.015  # [rad] way after which a joint goes where it is commanded, 0.1 m of the tip at 6 m; chosen
COMMANDED = 0.01  # [rad/s] of u, from which a way counts: less feeds leakage, or holds what rocks
MISFIT = 0.03  # [rad] between length and angle: thrice what sensors' static errors give; chosen
IDLE = 0.95  # [1] of the idle pressure: pumps kept 0.97 in motion, loads pressed up to 0.91 into dead ones
STRANGE = 0.3  # [s] for which lengths may not fit: samples of different moments, while nothing moves yet
FITS, BOOM, STICK, POLARITY = 0, 1, 2, 3  # [1] of `wrong`: what is; 3, 4, 5: of swing, boom, stick
GAIN, LIGHT = 6, 9  # [1] of `wrong`, by `machine_answers`; 6, 7, 8: of swing, boom, stick


class FileCheck(NamedTuple):
    """What the machine has answered since the controller's start."""

    ways: Vec3 = ZERO  # [rad]; of a joint that has proven right: `PROVEN`
    sides: Vec3 = ZERO  # [1] to which each was commanded last, -1 or 1; 0: not yet
    strange: float = 0.0  # [s] for which lengths have not fitted
    fitted: bool = False  # they once did
    wrong: int = FITS  # for good; `BOOM` and `STICK`, once lengths have fitted, while they do not
    answers: Answers = NO_ANSWERS
    starved: bool = False  # what is wrong was judged without the pump's pressure


def updated_check(
    before: FileCheck,
    angles: Vec3,
    rates: Vec3,
    lengths: Lengths,
    asked: Vec3,
    voltages: Vec3,
    overload: Overload,
    pressures: Pressures,
    supply: float,
    p: Parameters,
    dt: float,
) -> FileCheck:
    """Return the check after a sample.

    Args:
        before: as it was.
        angles: measured joint angles [rad].
        rates: measured joint rates [rad/s].
        lengths: of the cylinders of boom and stick [m]; NaN: not measured.
        asked: joint rates [rad/s] of the command since the last sample.
        voltages: of the valves, as the driver says [V]: what no open valve has moved proves nothing.
        overload: joints that have gone against their valves, and for how long these have been open.
        pressures: in the boom's cylinder, head and rod side [Pa]; NaN: not measured.
        supply: pressure of the pump [Pa]; NaN: not measured.
        p: the controller's parameters.
        dt: since the last sample [s].
    """
    if before.wrong >= POLARITY or (before.wrong != FITS and not before.fitted):
        return before
    loaded = overloaded_joint.borne(voltages, pressures, p) > BORNE
    u = _opened_for(asked, voltages, loaded, p)
    sides = _side(before.sides[0], u[0]), _side(before.sides[1], u[1]), _side(before.sides[2], u[2])
    ways = (
        _way(before, sides, rates, u, is_fed(overload, 0, p), 0, dt),
        _way(before, sides, rates, u, is_fed(overload, 1, p), 1, dt),
        _way(before, sides, rates, u, is_fed(overload, 2, p), 2, dt),
    )
    answers = machine_answers.answered(before.answers, angles, u, rates, pressures, p, dt)
    boom, stick = _misfit(lengths[0], angles[1], 0, p), _misfit(lengths[1], angles[2], 1, p)
    fitted = before.fitted or (boom <= MISFIT and stick <= MISFIT)
    most = FARTHEST if fitted else math.inf
    strange = before.strange + dt if MISFIT < boom <= most or MISFIT < stick <= most else 0.0
    wrong = FITS
    if strange > STRANGE:
        wrong = BOOM if MISFIT < boom <= most else STICK
    if machine_answers.is_too_light(answers):
        wrong = LIGHT
    for i in range(3):
        if machine_answers.is_of_another_rate(answers, i):
            wrong = GAIN + i
        goes_back = asked[i] != 0.0 and overloaded_joint.goes_back(overload, i) and not (i == 1 and loaded)
        if ways[i] < -PROVEN or (ways[i] < PROVEN and goes_back):
            wrong = POLARITY + i
    starved = wrong >= POLARITY and supply < IDLE * p.speed_limits.idle_pressure
    return FileCheck(ways, sides, strange, fitted, wrong, answers, starved)


def _opened_for(asked: Vec3, voltages: Vec3, loaded: bool, p: Parameters) -> Vec3:
    """Return the joint rates [rad/s] asked of open valves; none of a boom that a load presses back."""
    return (
        asked[0] if opens(voltages[0], 0, p) else 0.0,
        asked[1] if opens(voltages[1], 1, p) and not loaded else 0.0,
        asked[2] if opens(voltages[2], 2, p) else 0.0,
    )


def _side(before: float, u: float) -> float:
    """Return the side [1] to which a joint was commanded last."""
    return math.copysign(1.0, u) if u != 0.0 else before


def _way(before: FileCheck, sides: Vec3, rates: Vec3, u: Vec3, fed: bool, i: int, dt: float) -> float:
    """Return the way of one joint [rad]; fed: its valve has its pressure.

    A swing that goes back faster than its valve would lead it is pulled, by a load that sways.
    """
    if before.ways[i] >= PROVEN:
        return PROVEN
    begun = 0.0 if before.sides[i] * sides[i] < 0.0 else before.ways[i]
    if abs(u[i]) < COMMANDED or not fed:
        return begun
    gone = sides[i] * rates[i]
    if i == 0:
        gone = max(gone, -FASTEST * abs(u[i]))
    return min(PROVEN, begun + gone * dt)


def _misfit(length: float, angle: float, i: int, p: Parameters) -> float:
    """Return by how much an angle [rad] is not that of a cylinder's length [m]; NaN: it is not measured."""
    if math.isnan(length):
        return length
    error = abs(angle_at(length, p.linkages[i]) - angle)
    return math.inf if math.isnan(error) else error


def is_wrong(check: FileCheck) -> bool:
    """Tell whether the machine is another one than the file tells of; `objection` says what of it."""
    return check.wrong != FITS


def objection(check: FileCheck) -> str:
    """Return what does not fit the machine's file and what is to be done, or ""."""
    if check.wrong == FITS:
        return ""
    if check.wrong in (BOOM, STICK):
        return (
            f"machine file: the length of the {AXES[check.wrong]}'s cylinder does not belong to its angle;"
            f" allowed: parameter machine of this crane, and a new start; or position_source joints, if the"
            f" transducer is broken"
        )
    if check.starved:
        return (
            f"supply: less than the pump keeps at idle, and {_answer(check)}; allowed: start the pump, or"
            f" parameter machine of this crane; and a new start"
        )
    signs = "" if check.wrong >= GAIN else "valve and sensor of one sign, "
    return f"machine file: {_answer(check)}; allowed: {signs}parameter machine of this crane, and a new start"


def _answer(check: FileCheck) -> str:
    """Return what the machine has answered wrong."""
    if check.wrong == LIGHT:
        return "the pressures bear less than boom and stick weigh"
    if check.wrong >= GAIN:
        i = check.wrong - GAIN
        return f"{AXES[i]} goes {machine_answers.gain(check.answers, i):.1f} times as fast as commanded"
    return f"{AXES[check.wrong - POLARITY]} goes against its commands"
