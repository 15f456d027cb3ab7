"""What a record tells of the physics that the thesis leaves out, where the machine has them.

| section | record | numbers | motion that tells them |
|---|---|---|---|
| AXIS.friction | damping_AXIS | at speed, at breakaway | several speeds, through zero both ways |
| valve | valve, spool_lag | hysteresis, dead time, slew limit | steps up and down, with a spool sensor |
| valve.compensator | valve, compensator | all four | opening against a load that takes the pump's pressure |
| oil.air | damping_boom, damping_stick | free air | starts and stops, the load on either side |
| AXIS.holding_1, _2 | damping_AXIS | setting, pilot ratio | lowering at several speeds |
| swing.backlash | damping_swing | free way | several speeds, through zero both ways |
| valve of boom, stick | gravity | leakage | rests in several poses |

They have no linear estimate. Each begins with the machine's number and `UNKNOWN` as its prior's standard
deviation, so a record that tells nothing of one leaves it there: "the data cannot tell".
"""

import math
from collections.abc import Mapping, Sequence

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.measurements.parameter_path import part_of, valve_section
from forest_ident.output_error.prediction import STEP

UNKNOWN = 0.4  # standard deviation of the prior, relative
COARSE = {"dead_time": 0.25}
"""Relative differences for derivatives, where the simulator rounds a number to its own steps."""
FRICTION = ("coulomb_force", "breakaway_force", "coulomb_torque", "breakaway_torque")
PLAY = ("hysteresis", "dead_time", "spool_slew_limit")
HOLDING = ("setting", "pilot_ratio")
COMPENSATOR = tuple(
    f"compensator.{name}" for name in ("setting", "control_range", "minimum_resistance", "response_time")
)
FREE_WAY, LEAKAGE = "backlash.free_way", "leakage_conductance"
NAMES = (*FRICTION, *PLAY, *HOLDING, *COMPENSATOR, "oil.air.share", FREE_WAY, LEAKAGE)


def told_by(machine: Machine, kind: str, axis: str, valve: str) -> tuple[str, ...]:
    """Return the dotted keys that a record tells of, as far as the machine has them.

    Args:
        machine: as fitted.
        kind: of the record: "damping", "spool", "valve", "compensator", "gravity".
        axis: that the record is about.
        valve: section of that axis' valve.
    """
    keys: list[str] = []
    if kind == "damping":
        keys += _of_axis(axis)
        keys += ["oil.air.share"] if part_of(machine, f"{axis}.chambers") is not None else []
    if kind in ("spool", "valve"):
        keys += [f"{valve}.{name}" for name in PLAY]
    if kind in ("valve", "compensator"):
        keys += [f"{valve}.{name}" for name in COMPENSATOR]
    if kind == "gravity":
        keys += [f"{valve_section(machine, place)}.{LEAKAGE}" for place in (1, 2)]
    return tuple(key for key in dict.fromkeys(keys) if part_of(machine, key))


def felt_by(machine: Machine, kind: str, axes: Sequence[str], valve: str) -> tuple[str, ...]:
    """Return the dotted keys that a record feels, whether it tells them or not, as the machine has them.

    They go along with their uncertainty: held at the start's number, they would bend what is estimated. Not
    in `gravity`: stated numbers leave ten times as much in its masses, and its search would take five times
    as long.

    Args:
        machine: as fitted.
        kind: of the record: "hose", "motor", "deadband", "damping".
        axes: that move in it; none on a rig.
        valve: section of the valve that drives them, or is on the rig.
    """
    if kind in ("spool", "gravity"):
        return ()
    keys = ["oil.air.share", *(f"{valve}.{name}" for name in COMPENSATOR)]
    for axis in axes:
        keys += _of_axis(axis)
        # A shut valve's leakage looks like the motor's own.
        keys += [f"{valve_section(machine, AXES.index(axis))}.{LEAKAGE}"] if kind == "motor" else []
    return tuple(key for key in keys if part_of(machine, key))


def _of_axis(axis: str) -> list[str]:
    """Return the dotted keys of an axis' friction, load-holding valves and backlash."""
    holding = [f"{axis}.holding_{port}.{name}" for port in (1, 2) for name in HOLDING]
    return [*(f"{axis}.friction.{name}" for name in FRICTION), *holding, f"{axis}.{FREE_WAY}"]


def of_machine(machine: Machine) -> tuple[str, ...]:
    """Return the dotted keys of all these numbers that a machine has."""
    valves = dict.fromkeys(valve_section(machine, axis) for axis in range(3))
    keys = [f"{valve}.{name}" for valve in valves for name in (*PLAY, *COMPENSATOR, LEAKAGE)]
    keys += ["oil.air.share", *(key for axis in AXES for key in _of_axis(axis))]
    return tuple(key for key in keys if part_of(machine, key))


def begins_far_off(key: str) -> bool:
    """Tell whether a search must begin with a number: it scales the flow as a valve's C_R does."""
    return not is_extension(key) or key.endswith(COMPENSATOR)


def rounding(values: Mapping[str, float]) -> dict[str, float]:
    """Return the relative standard deviation that the simulator's steps add to numbers rounded to them."""
    return {
        key: STEP / math.sqrt(12.0) / value
        for key, value in values.items()
        if key.rpartition(".")[2] in COARSE and value > 0.0
    }


def is_extension(key: str) -> bool:
    """Tell whether a key is one of these."""
    return key.endswith(NAMES)
