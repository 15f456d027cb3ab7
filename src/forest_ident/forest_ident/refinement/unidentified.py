"""What the records of a fit could not tell, because they were not made: each with the motion that would."""

from __future__ import annotations

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.estimators.estimate import motion_for
from forest_ident.refinement.refinement import hose_section, valve_section
from forest_ident.refinement.result import Result

VALVE = ("deadband_voltage", "minimum_resistance")
LEAKAGE = ("swing.internal_leakage_resistance", "swing.external_leakage_resistance")
MASSES = tuple(f"manipulator.{name}" for name in ("head_mass", "boom_mass", "stick_mass", "base_zz"))


def sought(machine: Machine) -> tuple[str, ...]:
    """Return the keys of all that identification is asked for on a machine."""
    valves = dict.fromkeys(valve_section(machine, axis) for axis in range(3))
    keys = ["pump.supply_pressure"]
    keys += [f"{section}.{part}" for section in valves for part in VALVE]
    for axis in range(3):
        section, regime = hose_section(machine, axis), machine.drives[axis].flow_regime
        keys += [f"{section}.{part}" for part in (f"{regime}_resistance", "inertance", "capacitance")]
    return (*dict.fromkeys(keys), *LEAKAGE, *(f"{axis}.damping" for axis in AXES), *MASSES)


def untold(result: Result) -> list[tuple[str, str]]:
    """Return keys that stay as they were told, and what it takes to find them.

    A mass that rests confirmed within its error is no estimate, but it is told.
    """
    told = {*result.estimates, *(first.key for first in result.linear)}
    return [(key, motion_for(key)) for key in sought(result.start) if key not in told]
