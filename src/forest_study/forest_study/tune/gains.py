"""What is searched: K_p of three joints, damping of the swing, lead times. K_i goes with K_p by the rule.

A point has a number for each of `NAMES`, in units of `UNITS`: so a step of one is as large in all of them.
"""

from collections.abc import Sequence

from forest_control.config.controller_settings import Settings, with_rules
from forest_control.servo.gain_rule import integral
from forest_description.machine import Machine

Point = tuple[float, ...]
NAMES = ("K_p swing", "K_p boom", "K_p stick", "D swing", "T swing", "T boom", "T stick")
UNITS = (2.0, 2.0, 2.0, 0.4, 0.02, 0.02, 0.02)  # [1/s], [1], [s]: about what a step may change
LOWEST = (0.25, 0.25, 0.25, 0.0, 0.0, 0.0, 0.0)  # [1/s], [1], [s]: K_p of the rule's least
# [1/s], [1], [s]: beyond, no shipped machine's loop is damped
HIGHEST = (12.0, 12.0, 12.0, 1.0, 0.1, 0.1, 0.1)
DIGITS = 4  # of a gain that is kept: so a profile has the very gains that were judged
BOUNDS = tuple((low / unit, high / unit) for low, high, unit in zip(LOWEST, HIGHEST, UNITS, strict=True))


def point_of(machine: Machine) -> Point:
    """Return the rule's gains of a machine as a point."""
    told = with_rules(machine, Settings())
    values = *told.feedback_gain, told.rate_gain[0], *told.lead_time
    return tuple(value / unit for value, unit in zip(values, UNITS, strict=True))


def settings_of(point: Sequence[float]) -> Settings:
    """Return the controller's settings of a point."""
    one, two, three, damping, *lead = (
        _kept(min(high, max(low, x * unit)))
        for x, unit, low, high in zip(point, UNITS, LOWEST, HIGHEST, strict=True)
    )
    return Settings(
        feedback_gain=(one, two, three),
        integral_gain=(_kept(integral(one, 0)), _kept(integral(two, 1)), _kept(integral(three, 2))),
        rate_gain=(damping, 0.0, 0.0),
        lead_time=(lead[0], lead[1], lead[2]),
    )


def _kept(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def gains_of(settings: Settings) -> dict[str, list[float]]:
    """Return the gains as a profile has them."""
    names = ("feedback_gain", "integral_gain", "rate_gain", "lead_time")
    return {name: [float(x) for x in getattr(settings, name)] for name in names}


def profile(settings: Settings, head: Sequence[str]) -> str:
    """Return a profile's text, its head as comments."""
    lines = [f"# {line}" for line in head] + [f"{name}: {x}" for name, x in gains_of(settings).items()]
    return "\n".join(lines) + "\n"
