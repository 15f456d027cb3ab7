"""Which numbers everyday work is asked for, and what is known of each before.

Each axis has its valve's overlap and resistance by direction, its damping, and what its own physics has. What
a person tells (masses, lengths, areas) goes along with its uncertainty: held, it would bend the others.
"""

from collections.abc import Mapping

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.estimators.parameter_estimate import NORMAL_95
from forest_ident.measurements.parameter_path import hose_section, part_of, value_of, with_directions
from forest_ident.measurements.session import Session
from forest_ident.output_error import noise_model
from forest_ident.output_error.fit_problem import Unknown
from forest_ident.refinement import extension_keys, stated_numbers
from forest_ident.refinement.refinement_task import LEAKAGE, VALVE
from forest_ident.refinement.unknowns import ANGLES, UNKNOWN

SENSORS = (*ANGLES, "oil.offset")  # in the order of `Offsets`
DIFFERENCE = 1e-2  # relative: finer, a crane that sticks answers with chance


def prepared(machine: Machine) -> Machine:
    """Return the machine with a valve of its own for each axis, by direction."""
    for axis in AXES:
        machine = with_directions(machine, f"{axis}.valve")
    return machine


def wanted(machine: Machine) -> tuple[str, ...]:
    """Return the keys that are asked for, of a prepared machine."""
    keys = [f"pump.{name}" for name in machine.pump.identifiable]
    for place, axis in enumerate(AXES):
        hose, regime = hose_section(machine, place), machine.drives[place].flow_regime
        keys += [f"{axis}.valve{way}.{name}" for way in ("", ".backward") for name in VALVE]
        keys += [f"{axis}.damping", f"{hose}.{regime}_resistance"]
    keys += [*LEAKAGE, "manipulator.head_mass", *extension_keys.of_machine(machine)]
    return tuple(key for key in dict.fromkeys(keys) if _is_there(machine, key))


def unknowns(machine: Machine, stated: Mapping[str, float], session: Session) -> list[Unknown]:
    """Return what is fitted, with its prior.

    Args:
        machine: prepared.
        stated: half-widths [SI] of the 95 % intervals that the start's file states, by dotted key.
        session: read by the sensors, whose static errors are unknown, too.
    """
    found = [_unknown(machine, key, stated) for key in wanted(machine)]
    told = stated_numbers.errors(machine, stated)
    return found + [
        Unknown(
            key,
            0.0 if key in SENSORS else stated_numbers.stated_value(machine, key),
            sd,
            positive=False,
            difference=sd,
        )
        for key, sd in (told | _static(machine, session)).items()
    ]


def _static(machine: Machine, session: Session) -> dict[str, float]:
    """Return standard deviations of the static errors of the sensors that a prediction starts with."""
    kinds = zip(SENSORS, ("resolver", "resolver", "resolver", "thermocouple"), strict=True)
    found = {name: noise_model.accuracy(machine, session, kind) for name, kind in kinds}
    if session.temperature() is None or machine.oil is None:
        del found["oil.offset"]
    return {name: sd for name, sd in found.items() if sd > 0.0}


def _unknown(machine: Machine, key: str, stated: Mapping[str, float]) -> Unknown:
    value = value_of(machine, key)
    half = next((stated[name] for name in _names(key) if name in stated), None)
    prior = UNKNOWN if half is None else half / NORMAL_95 / value
    coarse = extension_keys.COARSE.get(key.rpartition(".")[2], DIFFERENCE)
    # An overlap, too, is positive: with one far off, derivatives are others.
    return Unknown(key, value, prior, difference=min(coarse, prior), begun=True)


def _names(key: str) -> tuple[str, ...]:
    """Return the keys under which a file may state a number: its own, of both directions, of all axes."""
    own = key.replace("backward.", "")
    shared = own.partition(".")[2] if ".valve." in own else own
    return key, own, shared


def _is_there(machine: Machine, key: str) -> bool:
    value = part_of(machine, key)
    return isinstance(value, float) and value > 0.0
