"""The linear estimators of Thesis section 4.3, as far as a session supports them."""

import math

import numpy as np

from forest_description.machine import Machine
from forest_description.sensors.sensor_kinds import FlowMeter
from forest_description.types import AXES
from forest_ident.estimators import (
    damping,
    gravity,
    hose_estimators,
    motor_leakage,
    valve_estimate,
)
from forest_ident.estimators.least_squares import LinearFit
from forest_ident.estimators.parameter_estimate import Estimate, unit_of
from forest_ident.experiments import rigs
from forest_ident.measurements import sample_mask
from forest_ident.measurements.parameter_path import hose_section, value_of, valve_at, with_part
from forest_ident.measurements.session import Session, SessionError
from forest_ident.refinement.refinement_task import MASSES

ENOUGH = 4  # steady openings each way, steady flows: fewer do not make a line
OTHER_LAW = 2.0  # times the residuals of the other law of a hose's resistance
POSES = 3  # at rest, that tell two masses
LONG = 20.0  # [s]: of creep, or of oil in the drain
MOVED = 0.05  # [rad]


def meter(machine: Machine, session: Session | None = None) -> FlowMeter | None:
    """Return the flow meters of a machine's bench; None for exact ones."""
    exact = session is not None and session.is_exact
    return None if exact else rigs.meters(machine).flow_meter


def floor(machine: Machine, session: Session | None = None) -> float:
    """Return the flow meters' floor [m^3/s]; 0 for exact ones."""
    read = meter(machine, session)
    return read.lowest if read else 0.0


def highest(machine: Machine, session: Session) -> float:
    """Return the flow meters' greatest flow [m^3/s]; inf for exact ones."""
    read = meter(machine, session)
    return read.highest if read else math.inf


def with_measured_hose(machine: Machine, axis: int) -> Machine:
    """Return the machine with the hose of an axis described as a measured one."""
    return with_part(machine, hose_section(machine, axis), rigs.as_measured(machine, machine.hose_of(axis)))


def estimates(machine: Machine, session: Session) -> list[Estimate]:
    """Return the linear estimates from a session; none from an experiment without a linear estimator.

    Args:
        machine: as far as it is known; a motor's internal leakage needs its external one, damping the areas.
        session: any.

    Raises:
        SessionError: the record does not hold what its experiment is made for.
    """
    if session.kind == "valve":
        return _valve(machine, session)
    if session.kind == "hose":
        return _hose(machine, session)
    if session.kind == "motor":
        _require(session, session.time[-1] >= LONG, f"{session.time[-1]:.0f} s", f"{LONG:.0f} s or more")
    if session.name == "motor_external":
        measured = session.has("case_drain") or "case_drain_volume" in session.metadata
        _require(session, measured, "no flow of the case drain", "its meter, or the fact case_drain_volume")
        fit = motor_leakage.external(machine, session)
        return [_inverse("swing.external_leakage_resistance", fit, "case drain (4.8)")]
    if session.name == "motor_internal":
        drained = 1.0 / value_of(machine, "swing.external_leakage_resistance")
        fit = motor_leakage.internal(machine, session, drained)
        return [_inverse("swing.internal_leakage_resistance", fit, "creep on the tilted platform (4.7)")]
    if session.kind == "damping" and session.own_axis:
        moved = float(np.ptp(session.column(f"{session.own_axis}_resolver")))
        _require(session, moved > MOVED, f"a motion over {moved:.3f} rad", f"more than {MOVED} rad")
        fit = damping.damping(machine, session, AXES.index(session.own_axis))
        return [_estimate(f"{session.own_axis}.damping", *fit.first, fit.condition, "least squares (4.11)")]
    return _masses(machine, session) if session.name == "gravity" else []


def _masses(machine: Machine, session: Session) -> list[Estimate]:
    """Return head and boom from forces at rest; the stick, which pulls as the head does, is as stated."""
    names = [key.rpartition(".")[2] for key in MASSES if value_of(machine, key) > 0.0]
    count = len(gravity.poses(machine, session)[0])
    _require(session, count >= POSES, f"{count} poses at rest", f"{POSES} or more")
    if machine.manipulator.log is not None:  # which pulls as the head does, too
        return []
    fit = gravity.masses(machine, session, tuple(names))
    pairs = zip(names, fit.values.tolist(), fit.errors.tolist(), strict=True)
    return [
        _estimate(f"manipulator.{name}", value, error, fit.condition, "forces at rest")
        for name, value, error in pairs
    ]


def _require(session: Session, there: bool, holds: str, allowed: str) -> None:
    """Refuse a session that does not hold what its experiment is made for.

    Raises:
        SessionError: it does not.
    """
    if not there:
        raise SessionError(f"{session.name}: the record holds {holds}; it takes {allowed}")


def _estimate(
    key: str, value: float, error: float, condition: float, method: str, initial: bool = True
) -> Estimate:
    return Estimate(
        key=key,
        value=value,
        standard_error=error,
        unit=unit_of(key),
        condition=condition,
        method=method,
        initial=initial,
    )


def _valve(machine: Machine, session: Session) -> list[Estimate]:
    section = f"{session.own_axis}.valve" if session.own_axis else "valve"
    read, low = meter(machine, session), floor(machine, session)
    points = valve_estimate.points(session, highest(machine, session))
    seen = np.abs(points.flow) > sample_mask.AT_FLOOR * low
    ways = [int(np.sum(seen & (np.sign(points.voltage) == way))) for way in (1.0, -1.0)]
    holds = f"{ways[0]} steady openings forward and {ways[1]} backward with flow above the meter's floor"
    _require(session, min(ways) >= ENOUGH, holds, f"{ENOUGH} each or more")
    noise = (read.noise or 0.0) if read else 0.0
    noise = max(noise / math.sqrt(float(np.median(points.samples))), 1e-10)
    fit = valve_estimate.law(points, valve_at(machine, section), low, noise)
    method = "C_R(V), flow below the floor censored (4.1)"
    return [
        _estimate(f"{section}.{key}", fit.values[key], fit.errors[key], fit.condition, method)
        for key in valve_estimate.KEYS
    ]


def _hose(machine: Machine, session: Session) -> list[Estimate]:
    missing = [name for name in ("hose_axis", "laminar") if name not in session.metadata]
    _require(session, not missing, f"no fact {', '.join(missing)}", "hose_axis (0, 1, 2) and laminar (0, 1)")
    laminar, axis = session.metadata["laminar"] > 0.0, int(session.metadata["hose_axis"])
    section, length = hose_section(machine, axis), rigs.as_measured(machine, machine.hose_of(axis)).length
    piece = session.metadata.get("hose_length", length)
    allowed = f"the {length:g} m of {section}.length, in whose numbers R, I and C are told"
    _require(session, math.isclose(piece, length, rel_tol=1e-3), f"a piece of {piece:g} m", allowed)
    low, high = floor(machine, session), highest(machine, session)
    flow, drop = hose_estimators.steady(session, low, high)
    _require(session, len(flow) >= ENOUGH, f"{len(flow)} steady flows", f"{ENOUGH} or more")
    fit = hose_estimators.resistance(flow, drop, laminar)
    other = hose_estimators.resistance(flow, drop, not laminar)
    obeys = float(np.linalg.norm(fit.residuals)) < OTHER_LAW * float(np.linalg.norm(other.residuals))
    laws = "the flow", "its square"
    holds = (
        f"a drop that goes with {laws[laminar]}, as the {'turbulent' if laminar else 'laminar'} hose's does"
    )
    _require(session, obeys, holds, f"one that goes with {laws[not laminar]}")
    key = f"{section}.{'laminar' if laminar else 'turbulent'}_resistance"
    found = [_estimate(key, *fit.first, fit.condition, "least squares (4.4)")]
    read, value = meter(machine, session), fit.first[0]
    lag = read.time_constant if read else 0.0
    joint = hose_estimators.joint(session, value, laminar, lag, low, high)
    groups = hose_estimators.four_group_means(session, value, laminar)
    for name, fit, means in zip(("inertance", "capacitance"), joint, groups, strict=True):
        key, error = f"{section}.{name}", float(np.std(means, ddof=1) / math.sqrt(len(means)))
        mean, method = float(np.mean(means)), "four-group means (4.3.4.4)"
        found.append(_estimate(key, mean, error, math.nan, method, initial=False))
        found.append(_estimate(key, *fit.first, fit.condition, "joint fit in phase (4.5a, 4.6)"))
    return found


def _inverse(key: str, fit: LinearFit, method: str) -> Estimate:
    """Return the estimate of a resistance from a fit of its conductance."""
    conductance, error = fit.first
    if conductance <= 0.0:
        return _estimate(key, math.nan, math.nan, math.inf, method)
    value = 1.0 / conductance
    return _estimate(key, value, value * error / conductance, fit.condition, method)
