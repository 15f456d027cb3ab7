"""The controller's settings as parameters that people set, also while it runs: names, units, ranges.

A name is that of the field of `Settings`; of fields that are enumerations people type the member's name.
"""

from collections.abc import Mapping
from enum import IntEnum
from typing import Any, NamedTuple

from forest_control.config.settings import Settings
from forest_control.operator.operator_profile import Frame, Mode
from forest_control.servo.joint_angle_filter import Source
from forest_control.servo.schemes import LABELS, Scheme


class Tunable(NamedTuple):
    """A setting as a parameter."""

    name: str
    doc: str
    unit: str = ""
    low: float | None = None
    high: float | None = None
    choices: tuple[str, ...] | None = None


ENUMERATIONS: dict[str, type[IntEnum]] = {
    "scheme": Scheme,
    "mode": Mode,
    "axis_frame": Frame,
    "position_source": Source,
}
TUNABLES = (
    Tunable("scheme", "control scheme", choices=LABELS),
    Tunable("mode", "what a deflection means", choices=("rate", "position")),
    Tunable(
        "position_source",
        "what tells boom and stick: resolvers, or these corrected by the cylinders; heeded at rest",
        choices=("joints", "cylinders"),
    ),
    Tunable("axis_frame", "along what the tip's axes lie", choices=("cartesian", "cylindrical")),
    Tunable("deadzone", "deflection of each lever that counts as none", "", 0.0, 0.5),
    Tunable("expo", "how much of each lever's curve is cubic", "", 0.0, 1.0),
    Tunable("tip_speed", "tip speed at full deflection", "m/s", 0.01, 3.0),
    Tunable("axis_speed", "largest tip speed of each lever", "m/s", 0.01, 3.0),
    Tunable("position_span", "of the tip at full deflection in position mode", "m", 0.01, 3.0),
    Tunable("joint_span", "of the joints at full deflection in position mode", "rad", 0.001, 1.0),
    Tunable("joint_rates", "largest joint rates", "rad/s", 0.01, 3.0),
    Tunable("velocity_gain", "K_v of schemes (a) and (c)", "", 0.01, 10.0),
    Tunable("position_gain", "K_p of schemes (b) and (d)", "1/s", 0.0, 50.0),
    Tunable("damping_gain", "K_d of schemes (b) and (d)", "", -0.9, 10.0),
    Tunable("jacobian_at_joints", "scheme (d) takes J^-1 at the measured angles, as the thesis does"),
    Tunable("lead", "how far the reference may run ahead of a joint", "rad", 0.001, 1.0),
    Tunable("feedback_gain", "K_p of the coordinated scheme", "1/s", 0.0, 30.0),
    Tunable("integral_gain", "K_i of the coordinated scheme", "1/s^2", 0.0, 50.0),
    Tunable("rate_gain", "D of the coordinated scheme: damping by the measured rate", "", 0.0, 2.0),
    Tunable("lead_time", "T of the coordinated scheme: what the machine lags behind", "s", 0.0, 0.5),
    Tunable("load_bandwidth", "of the valve driver's knowledge of the load", "Hz", 0.01, 50.0),
    Tunable("tip_acceleration", "of the coordinated scheme's reference", "m/s^2", 0.1, 20.0),
    Tunable("joint_margin", "kept from joint limits", "rad", 0.0, 0.2),
    Tunable("approach", "speed per angle, of a cylinder per stroke, left to a limit", "1/s", 0.1, 20.0),
)


def as_typed(name: str, settings: Settings) -> Any:
    """Return a setting's value as people type it."""
    value = getattr(settings, name)
    return value.name.lower() if isinstance(value, IntEnum) else value


def settings_from(typed: Mapping[str, Any]) -> Settings:
    """Return the settings that were typed, a value for each of `TUNABLES`."""
    settings = {name: value for name, value in typed.items() if name in Settings._fields}
    members = {name: kind[typed[name].upper()] for name, kind in ENUMERATIONS.items()}
    return Settings(**{**settings, **members})
