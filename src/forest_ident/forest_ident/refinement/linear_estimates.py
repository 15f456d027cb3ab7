"""The estimators of Thesis section 4.3 on sessions: which of them a session supports, and what they say."""

from __future__ import annotations

import dataclasses
import math
from typing import Any, NamedTuple

import numpy as np

from forest_description.components.sensors import FlowMeter
from forest_description.machine import CylinderDrive, Machine, SwingDrive
from forest_description.types import AXES
from forest_ident.estimators import (
    damping,
    hose_dynamics,
    hose_resistance,
    motor_leakage,
    valve_characteristic,
)
from forest_ident.estimators.least_squares import Line
from forest_ident.experiments import test_rig
from forest_ident.measurements import sample_mask
from forest_ident.measurements.parameter_path import value_of
from forest_ident.measurements.session import Session, SessionError
from forest_ident.refinement.refinement import hose_section

ENOUGH = 4  # steady openings each way, steady flows: fewer do not make a line
LONG = 20.0  # [s]: of creep, or of oil in the drain
MOVED = 0.05  # [rad]


class First(NamedTuple):
    """An estimate by a linear fit; ``main``: the refinement starts from it."""

    key: str
    value: float
    error: float
    condition: float
    method: str
    main: bool = True


def meter(machine: Machine, session: Session | None = None) -> FlowMeter | None:
    """Return the flow meters of a machine's bench; None for exact ones."""
    if session is not None and session.is_exact:
        return None
    return test_rig.meters(machine).flow_meter


def floor(machine: Machine, session: Session | None = None) -> float:
    """Return the flow meters' floor [m^3/s]; 0 for exact ones."""
    read = meter(machine, session)
    return read.lowest if read else 0.0


def highest(machine: Machine, session: Session) -> float:
    """Return the flow meters' greatest flow [m^3/s]; inf for exact ones."""
    read = meter(machine, session)
    return read.highest if read else math.inf


def with_measured_hose(machine: Machine, axis: int) -> Machine:
    """Return the machine with the hose of an axis told as a measured one."""
    section = hose_section(machine, axis)
    hose = test_rig.as_measured(machine, machine.hose_of(axis))
    if section == "hose":
        return dataclasses.replace(machine, hose=hose)
    drive = dataclasses.replace(machine.drives[axis], hose=hose)
    return replaced_drive(machine, axis, drive)


def replaced_drive(machine: Machine, axis: int, drive: SwingDrive | CylinderDrive) -> Machine:
    """Return the machine with another drive on an axis."""
    changed: dict[str, Any] = {AXES[axis]: drive}
    return dataclasses.replace(machine, **changed)


def estimates(machine: Machine, session: Session) -> list[First]:
    """Return what the linear estimators make of a session.

    Args:
        machine: as far as it is known; a motor's internal leakage needs its external one, damping the areas.
        session: any; of an unknown name it supports nothing.

    Raises:
        SessionError: it does not hold what its experiment is made for.
    """
    kind, _, tail = session.name.partition("_")
    if kind == "valve":
        return _valve(machine, session, f"{tail}.valve" if tail in AXES else "valve")
    if kind == "hose":
        return _hose(machine, session)
    if kind == "motor":
        _demand(session, session.time[-1] >= LONG, f"{session.time[-1]:.0f} s", f"{LONG:.0f} s or more")
    if session.name == "motor_external":
        measured = session.has("case_drain") or "case_drain_volume" in session.facts
        _demand(session, measured, "no flow of the case drain", "its meter, or the fact case_drain_volume")
        line = motor_leakage.external(machine, session)
        return [_inverse("swing.external_leakage_resistance", line, "case drain (4.8)")]
    if session.name == "motor_internal":
        drained = 1.0 / value_of(machine, "swing.external_leakage_resistance")
        line = motor_leakage.internal(machine, session, drained)
        return [_inverse("swing.internal_leakage_resistance", line, "creep on the tilted platform (4.7)")]
    if kind == "damping" and tail in AXES:
        moved = float(np.ptp(session.column(f"{tail}_resolver")))
        _demand(session, moved > MOVED, f"a motion over {moved:.3f} rad", f"more than {MOVED} rad")
        line = damping.damping(machine, session, AXES.index(tail))
        value, error = float(line.values[0]), float(line.errors[0])
        return [
            First(
                key=f"{tail}.damping",
                value=value,
                error=error,
                condition=line.condition,
                method="least squares (4.11)",
            )
        ]
    return []


def _demand(session: Session, there: bool, holds: str, allowed: str) -> None:
    """Refuse a session that does not hold what its experiment is made for.

    Raises:
        SessionError: it does not.
    """
    if not there:
        raise SessionError(f"{session.name}: the record holds {holds}; it takes {allowed}")


def _valve(machine: Machine, session: Session, section: str) -> list[First]:
    points = valve_characteristic.points(session, highest(machine, session))
    seen = np.abs(points.flow) > sample_mask.AT_FLOOR * floor(machine, session)
    ways = [int(np.sum(seen & (np.sign(points.voltage) == way))) for way in (1.0, -1.0)]
    holds = f"{ways[0]} steady openings forward and {ways[1]} backward with flow above the meter's floor"
    _demand(session, min(ways) >= ENOUGH, holds, f"{ENOUGH} each or more")
    owner = getattr(machine, section.partition(".")[0]).valve if "." in section else machine.valve
    read = meter(machine, session)
    noise = (read.noise or 0.0) if read else 0.0
    noise = max(noise / math.sqrt(float(np.median(points.samples))), 1e-10)
    fit = valve_characteristic.law(points, owner, floor(machine, session), noise)
    keys = valve_characteristic.KEYS
    method = "C_R(V), flow below the floor censored (4.1)"
    return [
        First(
            key=f"{section}.{k}",
            value=fit.values[k],
            error=fit.errors[k],
            condition=fit.condition,
            method=method,
        )
        for k in keys
    ]


def _hose(machine: Machine, session: Session) -> list[First]:
    facts = [name for name in ("hose_axis", "laminar") if name not in session.facts]
    _demand(session, not facts, f"no fact {', '.join(facts)}", "hose_axis (0, 1, 2) and laminar (0, 1)")
    laminar, axis = session.facts["laminar"] > 0.0, int(session.facts["hose_axis"])
    section, length = hose_section(machine, axis), test_rig.as_measured(machine, machine.hose_of(axis)).length
    piece = session.facts.get("hose_length", length)
    told = f"the {length:g} m of {section}.length, in whose numbers R, I and C are told"
    _demand(session, math.isclose(piece, length, rel_tol=1e-3), f"a piece of {piece:g} m", told)
    low, high = floor(machine, session), highest(machine, session)
    flow, drop = hose_resistance.steady(session, low, high)
    _demand(session, len(flow) >= ENOUGH, f"{len(flow)} steady flows", f"{ENOUGH} or more")
    line = hose_resistance.resistance(flow, drop, laminar)
    key = f"{section}.{'laminar' if laminar else 'turbulent'}_resistance"
    value = float(line.values[0])
    found = [
        First(
            key=key,
            value=value,
            error=float(line.errors[0]),
            condition=line.condition,
            method="least squares (4.4)",
        )
    ]
    read = meter(machine, session)
    lag = read.time_constant if read else 0.0
    inertance, capacitance = hose_dynamics.joint(session, value, laminar, lag, low, high)
    groups = hose_dynamics.four_group_means(session, value, laminar)
    for name, one, means in zip(("inertance", "capacitance"), (inertance, capacitance), groups, strict=True):
        error = float(np.std(means, ddof=1) / math.sqrt(len(means)))
        key, by = f"{section}.{name}", "four-group means (4.3.4.4)"
        found.append(
            First(
                key=key, value=float(np.mean(means)), error=error, condition=math.nan, method=by, main=False
            )
        )
        value, error = float(one.values[0]), float(one.errors[0])
        found.append(
            First(
                key=key,
                value=value,
                error=error,
                condition=one.condition,
                method="joint fit in phase (4.5a, 4.6)",
            )
        )
    return found


def _inverse(key: str, line: Line, method: str) -> First:
    conductance, error = float(line.values[0]), float(line.errors[0])
    if conductance <= 0.0:
        return First(key=key, value=math.nan, error=math.nan, condition=math.inf, method=method)
    value = 1.0 / conductance
    return First(
        key=key, value=value, error=value * error / conductance, condition=line.condition, method=method
    )
