"""Unknowns of a record's fit, with their priors and the differences by which derivatives are taken.

Where no axis sticks, the readings bend smoothly, and differences are as fine as stated numbers need: one
standard deviation of the stick's mass moves `gravity` by 50 000 times the noise. The mean that a record
starts from leaves 0.2 to 0.4 of the noise, so its angles are unknowns of that record. A crane that sticks
answers any difference with the chance of which step its friction lets go in.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

from forest_description.machine import Machine
from forest_description.types import AXES
from forest_ident.estimators.parameter_estimate import is_positive
from forest_ident.measurements.parameter_path import value_of
from forest_ident.measurements.session import Session
from forest_ident.output_error import noise_model
from forest_ident.output_error.fit_problem import Unknown
from forest_ident.output_error.gaussian_estimate import GaussianEstimate
from forest_ident.refinement import extension_keys
from forest_ident.refinement.refinement_task import START, Task, tells_stated
from forest_ident.refinement.stated_numbers import stated_value

UNKNOWN = 0.4  # prior standard deviation of what no experiment has estimated yet: relative, or volts
BEGUN = 0.1  # standard deviation, as `UNKNOWN`, from which a search begins with a number
START_NOISE = 1e4  # [Pa] by which pressures drift while the mean of the start is taken
ANGLES = tuple(f"{axis}.angle" for axis in AXES)


class Differences(NamedTuple):
    """Moves by which derivatives are taken."""

    share: float  # of a positive number; [V] of an overlap
    angle: float  # [rad]
    pressure: float  # [Pa] at the start


FINE = Differences(1e-5, 1e-5, 1.0)
STICKING = Differences(1e-2, 1e-2, START_NOISE)
OF_STATED = 1e-5  # of a stated number's standard deviation; 0.005 feigns 330 times the noise in `gravity`


def of_record(machine: Machine, session: Session, work: Task, known: GaussianEstimate) -> list[Unknown]:
    """Return parameters and nuisances with their priors; exact sensors have no static errors.

    A record of the crane passes on only what it is made for.
    """
    found, by = [], _differences(machine, session)
    for key in (*work.free, *work.carried):
        positive = is_positive(key)
        # An overlap that a curve in volts hides stays near its start, or it would leave the curve behind.
        linear = not extension_keys.is_extension(key) and not key.startswith("pump.")
        spread = math.inf if key in work.free and positive and linear else UNKNOWN
        far = extension_keys.begins_far_off(key)
        unknown = Unknown(
            key=key,
            start=value_of(machine, key),
            prior=spread,
            positive=positive,
            own=session.on_crane and key in work.carried,
            begun=far and (session.on_crane or key in work.free) and not _is_known(known, key),
        )
        difference = extension_keys.COARSE.get(key.rpartition(".")[2], by.share)
        rounded = extension_keys.rounding({key: unknown.start}).get(key, 0.0)
        found.append(unknown._replace(difference=difference, rounded=rounded))
    if "rig.load" in work.nuisances:
        found.append(Unknown(f"rig.load.{session.name}", _load(session), math.inf, begun=True))
    for name in () if session.is_exact else work.nuisances:
        if name == "tilt":
            sd = noise_model.accuracy(machine, session, "inclinometer") or 0.01
            found.append(Unknown(name, 0.0, sd, positive=False, difference=by.angle))
        elif name == "oil.offset" and session.temperature() is not None and machine.oil is not None:
            sd = noise_model.accuracy(machine, session, "thermocouple") / math.sqrt(3.0)
            found.append(Unknown(name, 0.0, max(sd, 0.01), positive=False, difference=0.1))
        elif name in ANGLES and (sd := noise_model.accuracy(machine, session, "resolver")) > 0.0:
            # Where the start is an unknown, too, both move the crane alike, and this one its reading.
            start, by_chance = _start_angle(machine, session, name)
            like = (start, f"{name.partition('.')[0]}_resolver") if by_chance > 0.0 else None
            found.append(Unknown(name, 0.0, sd, positive=False, difference=by.angle, like=like))
    return found


def starts(machine: Machine, session: Session, work: Task, known: GaussianEstimate) -> list[Unknown]:
    """Return the unknown start of a crane's record: pressures; angles, too, where no axis sticks."""
    found = _start_pressures(machine, session, work, known)
    for angle in (name for name in ANGLES if name in work.nuisances):
        key, sd = _start_angle(machine, session, angle)
        if sd > 0.0:
            found.append(Unknown(key, 0.0, sd, positive=False, difference=FINE.angle, own=True))
    return found


def _start_angle(machine: Machine, session: Session, angle: str) -> tuple[str, float]:
    """Return the unknown start of an angle with its standard deviation; 0: it is none."""
    key = f"{START}{angle.partition('.')[0]}_resolver.{session.name}"
    unknown = tells_stated(machine) and session.on_crane
    return key, noise_model.start_noise(machine, session, angle) if unknown else 0.0


def stated(machine: Machine, felt: Mapping[str, float], known: GaussianEstimate) -> list[Unknown]:
    """Return stated numbers as unknowns; felt: standard deviations as told, by key.

    The first record that feels one passes it on.
    """
    return [
        Unknown(
            key=key,
            start=stated_value(machine, key),
            prior=sd,
            positive=False,
            difference=OF_STATED * sd,
            own=key in known.names,
        )
        for key, sd in felt.items()
    ]


def _differences(machine: Machine, session: Session) -> Differences:
    """Return those of a record: on a rig nothing sticks, and a valve next to shut bends much."""
    return FINE if session.on_rig or tells_stated(machine) else STICKING


def _is_known(known: GaussianEstimate, key: str) -> bool:
    """Tell whether earlier records tell a number well enough for a search to begin with."""
    return key in known.names and known.of(key)[1] < BEGUN


def _start_pressures(
    machine: Machine, session: Session, work: Task, known: GaussianEstimate
) -> list[Unknown]:
    """Return the pressures at the start of a crane's record: behind a shut valve they last for long."""
    found, by = [], _differences(machine, session)
    for name in work.channels if session.on_crane else ():
        if "_pressure_" not in name or not session.has(name):
            continue
        offset = noise_model.channel(machine, session, name).offset
        if f"{name}.b" in known.names:  # calibrated: the record is corrected by that
            _, offset = known.of(f"{name}.b")
        spread = math.hypot(offset, START_NOISE)
        found.append(
            Unknown(
                key=f"{START}{name}.{session.name}",
                start=0.0,
                prior=spread,
                positive=False,
                difference=by.pressure,
                own=True,
            )
        )
    return found


def _load(session: Session) -> float:
    """Return R_L [Pa s/m^3] of a bench's load from pressures and flow, to start from."""
    one, two = session.pressures("swing", "actuator")
    flow = session.column("swing_flow")
    return float((one - two) @ flow / (flow @ flow))
