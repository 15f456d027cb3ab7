"""Whether a joint's sensor stands still while its joint is told to move: frozen, or the joint is stuck.

A servo on a sensor that has frozen pushes on for ever, faster and faster, also with the levers centred. No
true sensor of a moving crane gives the same number again and again, to the last bit; so one that does, while
its joint should have moved by more than any sensor's resolution, is not believed.

| symbol | name | unit |
|---|---|---|
| s | measured joint angle | rad |
| u | commanded joint rate | rad/s |
| way | what the joint was told to move by since s changed last, integral of abs u | rad |

Not seen: a frozen sensor behind a converter that adds noise, and one that freezes while its joint rests.
"""

from typing import NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_description.derived.actuator_kinematics import actuator_speeds_to_joint_rates
from forest_description.types import AXES, Vec3

WAY = 0.02  # [rad] ten times the step of a resolver of 12 bits; 0.12 m at 6 m
LONG = 0.15  # [s] a valve, and the oil behind it, take as long to set a joint in motion


class Stillness(NamedTuple):
    """Of swing, boom, stick, since each moved last."""

    angles: Vec3  # s [rad]
    ways: Vec3  # [rad]
    times: Vec3  # [s]


MOVING = Stillness((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def updated_stillness(before: Stillness, s: Vec3, command: Vec3, p: Parameters, dt: float) -> Stillness:
    """Return the stillness after a sample.

    Args:
        before: as it was.
        s: measured angles [rad].
        command: of ideal valves [V] since the last sample.
        p: the controller's parameters.
        dt: since the last sample [s].
    """
    u = actuator_speeds_to_joint_rates(
        s,
        (
            command[0] * p.rated_speeds[0] / p.rated_voltages[0],
            command[1] * p.rated_speeds[1] / p.rated_voltages[1],
            command[2] * p.rated_speeds[2] / p.rated_voltages[2],
        ),
        p.linkages,
    )
    way_1, time_1 = _stood(before, s, u, 0, dt)
    way_2, time_2 = _stood(before, s, u, 1, dt)
    way_3, time_3 = _stood(before, s, u, 2, dt)
    return Stillness(s, (way_1, way_2, way_3), (time_1, time_2, time_3))


def _stood(before: Stillness, s: Vec3, u: Vec3, i: int, dt: float) -> tuple[float, float]:
    """Return way [rad] and time [s] for which one joint has stood still."""
    if s[i] != before.angles[i]:
        return 0.0, 0.0
    return before.ways[i] + abs(u[i]) * dt, before.times[i] + dt


def is_frozen(still: Stillness) -> bool:
    """Tell whether a joint's sensor does not follow its joint; `frozen` says which."""
    ways, times = still.ways, still.times
    return (
        (ways[0] > WAY and times[0] > LONG)
        or (ways[1] > WAY and times[1] > LONG)
        or (ways[2] > WAY and times[2] > LONG)
    )


def frozen(still: Stillness) -> str:
    """Return which joint's sensor does not follow its joint, or ""."""
    for name, way, time in zip(AXES, still.ways, still.times, strict=True):
        if way > WAY and time > LONG:
            return (
                f"joint state: {name} is the same to the last bit for {time:.2f} s though told to move by"
                f" {way:.3f} rad; its sensor is frozen, or it is stuck"
            )
    return ""
