"""What a record tells of the physics that the thesis leaves out, where the machine has them.

| section | record | numbers | motion that tells them |
|---|---|---|---|
| AXIS.friction | damping_AXIS | at speed, at breakaway | several speeds, through zero both ways |
| valve | valve, spool_lag | hysteresis, dead time, slew limit | steps up and down, with a spool sensor |
| oil.air | damping_boom, damping_stick | free air | starts and stops, the load on either side |
| AXIS.holding_1, _2 | damping_AXIS | setting, pilot ratio | lowering at several speeds |

They have no linear estimate. Each begins with the machine's number and `UNKNOWN` as its prior's standard
deviation, so a record that tells nothing of one leaves it there: "the data cannot tell".
"""

import math
from collections.abc import Mapping

from forest_description.machine import Machine
from forest_ident.measurements.parameter_path import part_of
from forest_ident.output_error.prediction import STEP

UNKNOWN = 0.4  # standard deviation of the prior, relative
COARSE = {"dead_time": 0.25}
"""Relative differences for derivatives, where the simulator rounds a number to its own steps."""
FRICTION = ("coulomb_force", "breakaway_force", "coulomb_torque", "breakaway_torque")
PLAY = ("hysteresis", "dead_time", "spool_slew_limit")
HOLDING = ("setting", "pilot_ratio")
NAMES = (*FRICTION, *PLAY, *HOLDING, "oil.air.share")


def told_by(machine: Machine, kind: str, axis: str, valve: str) -> tuple[str, ...]:
    """Return the dotted keys that a record tells of, as far as the machine has them.

    Args:
        machine: as fitted.
        kind: of the record: "damping", "spool", "valve".
        axis: that the record is about.
        valve: section of that axis' valve.
    """
    keys: list[str] = []
    if kind == "damping":
        keys += [f"{axis}.friction.{name}" for name in FRICTION]
        keys += [f"{axis}.holding_{port}.{name}" for port in (1, 2) for name in HOLDING]
        keys += ["oil.air.share"] if part_of(machine, f"{axis}.chambers") is not None else []
    if kind in ("spool", "valve"):
        keys += [f"{valve}.{name}" for name in PLAY]
    return tuple(key for key in keys if part_of(machine, key))


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
