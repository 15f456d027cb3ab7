"""The pictures of an identification, as Thesis fig. 4.4, 4.6, 4.8, 4.10 and 4.11 show theirs.

Measured solid or as points, fitted dotted, as there. Each function draws on axes it is given and returns
whether it had something to draw.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from forest_description.machine import Machine, MeasuredHose
from forest_description.types import AXES, Floats
from forest_ident.estimators import (
    damping,
    hose_dynamics,
    hose_resistance,
    motor_leakage,
    valve_characteristic,
)
from forest_ident.experiments import test_rig
from forest_ident.measurements.differentiator import derivative, smooth
from forest_ident.measurements.session import Session
from forest_ident.refinement import linear_estimates
from forest_ident.refinement.result import Refined

MOST = 99.5  # [%] of the samples that a picture's scale must hold
MEASURED, FITTED = {"color": "C0"}, {"color": "k", "linestyle": ":", "linewidth": 1.8}


def valve(axes: Any, machine: Machine, session: Session) -> None:
    """C_R over the voltage: read, the law, the polynomial. Thesis fig. 4.4."""
    low, high = linear_estimates.floor(machine, session), linear_estimates.highest(machine, session)
    points = valve_characteristic.points(session, high)
    c_r = valve_characteristic.resistance(points, low)
    order = np.argsort(points.voltage)
    volts, c_r = points.voltage[order], c_r[order]
    axes.semilogy(volts, c_r, ".", label="read", **MEASURED)
    one, _ = valve_characteristic.flows(_valve_of(machine, session), points)
    said = np.where(one != 0.0, points.drop_1 / np.maximum(one**2, 1e-30), math.nan)[order]
    axes.semilogy(volts, np.where(said < 1e18, said, math.nan), label="law", **FITTED)
    coefficients = valve_characteristic.polynomial(volts, c_r)
    seen = np.isfinite(c_r)
    if np.all(np.isfinite(coefficients)):
        curve = np.polynomial.polynomial.polyval(np.abs(volts[seen]), coefficients)
        axes.semilogy(volts[seen], np.where(curve > 0.0, curve, math.nan), "C1--", label="polynomial")
    axes.set(xlabel="voltage, V", ylabel="C_R, Pa s²/m⁶", title="Valve characteristic (fig. 4.4)")
    axes.legend()


def _valve_of(machine: Machine, session: Session) -> Any:
    tail = session.name.partition("_")[2]
    return machine.valve_of(AXES.index(tail)) if tail in AXES else machine.valve


def hose(axes: Any, machine: Machine, session: Session) -> None:
    """Pressure drop over flow. Thesis fig. 4.6."""
    laminar = session.facts.get("laminar", 0.0) > 0.0
    q, drop = hose_resistance.steady(
        session, linear_estimates.floor(machine, session), linear_estimates.highest(machine, session)
    )
    of = machine.hose_of(int(session.facts.get("hose_axis", 0.0)))
    r = getattr(of, "laminar_resistance" if laminar else "turbulent_resistance", math.nan)
    x = np.linspace(q.min(), q.max(), 100)
    axes.plot(1e3 * q, 1e-6 * drop, ".", label="read", **MEASURED)
    axes.plot(1e3 * x, 1e-6 * r * (x if laminar else x * np.abs(x)), label="fit", **FITTED)
    axes.set(xlabel="flow, L/s", ylabel="drop, MPa", title=f"{session.name}: resistance (fig. 4.6)")
    axes.legend()


def inertance(axes: Any, machine: Machine, session: Session) -> None:
    """What speeds the oil up over how fast it is sped up: the slope is I. Thesis fig. 4.8."""
    of, (drop, rate, _, _) = _dynamics(machine, session)
    _slope(axes, rate, 1e-6 * drop, 1e-6 * of.inertance)
    title = f"{session.name}: inertance (fig. 4.8)"
    axes.set(xlabel="dQ_1/dt, m³/s²", ylabel="P_in - P_c, MPa", title=title)


def capacitance(axes: Any, machine: Machine, session: Session) -> None:
    """Flow that stays in the hose over the rise of its pressure: the slope is C. Thesis fig. 4.8."""
    of, (_, _, difference, rate) = _dynamics(machine, session)
    _slope(axes, 1e-9 * rate, 1e3 * difference, 1e12 * of.capacitance)
    title = f"{session.name}: capacitance (fig. 4.8)"
    axes.set(xlabel="dP_c/dt, GPa/s", ylabel="Q_1 - Q_2, L/s", title=title)


def _dynamics(machine: Machine, session: Session) -> tuple[MeasuredHose, tuple[Floats, ...]]:
    """Return the hose, and every fifth row of the terms of its equations."""
    laminar = session.facts.get("laminar", 0.0) > 0.0
    of = test_rig.as_measured(machine, machine.hose_of(int(session.facts.get("hose_axis", 0.0))))
    r = of.laminar_resistance if laminar else of.turbulent_resistance
    meter = linear_estimates.meter(machine, session)
    lag = meter.time_constant if meter else 0.0
    *terms, rows = hose_dynamics.terms(session, r, laminar, lag)
    part = slice(rows.start, rows.stop, 5)
    return of, tuple(term[part] for term in terms)


def _slope(axes: Any, x: Floats, y: Floats, slope: float) -> None:
    """Points and the line through zero; a jump between two samples lies far out and does not count."""
    ends = np.percentile(np.abs(x), MOST) * np.array([-1.0, 1.0])
    axes.plot(x, y, ".", markersize=3, label="read", **MEASURED)
    axes.plot(ends, slope * ends, label="fit", **FITTED)
    axes.set(xlim=1.1 * ends, ylim=1.3 * slope * ends)
    axes.legend()


def external(axes: Any, machine: Machine, session: Session) -> None:
    """Case drain over the sum of the pressures. Thesis fig. 4.10."""
    total = session.column("swing_pressure_1_actuator") + session.column("swing_pressure_2_actuator")
    f = motor_leakage.warmth(machine, session)
    x = smooth(total * f, 2.0, session.period)
    r = machine.swing.external_leakage_resistance
    if session.has("case_drain"):
        y = smooth(session.column("case_drain"), 2.0, session.period)
        axes.plot(1e-6 * x[::20], 6e4 * y[::20], ".", markersize=2, label="read", **MEASURED)
    knots = np.array([0.0, float(x.max())])
    axes.plot(1e-6 * knots, 6e4 * knots / r, label="fit", **FITTED)
    axes.set(xlabel="P_1 + P_2, MPa", ylabel="case drain, L/min", title="External leakage (fig. 4.10)")
    axes.legend()


def internal(axes: Any, machine: Machine, session: Session) -> None:
    """What passes inside the motor over the pressure difference. Thesis fig. 4.10."""
    period, f = session.period, motor_leakage.warmth(machine, session)
    displacement = machine.swing.gear_ratio * machine.swing.motor_displacement
    band = motor_leakage.BANDWIDTH
    speed = np.abs(derivative(session.column("swing_resolver"), band, period))
    one, two = (smooth(session.column(f"swing_pressure_{k}_actuator"), band, period) for k in (1, 2))
    high = np.maximum(one, two)
    inside = displacement * speed - f * high / machine.swing.external_leakage_resistance
    x = f * (high - np.minimum(one, two))
    rows = slice(round(6.0 / period), -round(4.0 / period), 20)
    axes.plot(1e-6 * x[rows], 6e4 * inside[rows], ".", markersize=2, label="read", **MEASURED)
    knots = np.array([float(x[rows].min()), float(x[rows].max())])
    axes.plot(1e-6 * knots, 6e4 * knots / machine.swing.internal_leakage_resistance, label="fit", **FITTED)
    axes.set(xlabel="P_1 - P_2, MPa", ylabel="internal leakage, L/min", title="Internal leakage (fig. 4.10)")
    axes.legend()


def friction(axes: Any, machine: Machine, session: Session) -> None:
    """Force that the load does not take over speed. Thesis fig. 4.11."""
    axis = AXES.index(session.name.partition("_")[2])
    alpha, speed, _ = damping.equation(machine, session, axis)
    order = np.argsort(speed)
    axes.plot(speed[order], 1e-3 * alpha[order], ",", label="read", **MEASURED)
    axes.plot(speed[order], 1e-3 * machine.drives[axis].damping * speed[order], label="fit", **FITTED)
    units = ("rad/s", "kN m") if axis == 0 else ("m/s", "kN")
    axes.set(xlabel=f"speed, {units[0]}", ylabel=units[1], title=f"Damping, {AXES[axis]} (fig. 4.11)")
    axes.legend()


def whiteness(axes: Any, refined: Refined) -> None:
    """Autocorrelation of the refinement's residuals, with the band of white noise."""
    count = 0
    for name, residual in refined.fit.residuals.items():
        r = autocorrelation(residual)
        if r is not None:
            axes.plot(np.arange(1, len(r) + 1), r, linewidth=0.8, label=name)
            count = max(count, int(np.isfinite(residual).sum()))
    band = 1.96 / math.sqrt(max(count, 1))
    axes.axhspan(-band, band, color="0.85")
    axes.set(xlabel="lag, samples", ylim=(-0.3, 1.0), title=f"{refined.session.name}: residuals' correlation")
    axes.legend(fontsize=5)


def autocorrelation(residual: Any, lags: int = 40) -> Any:
    """Return the autocorrelation at lags 1 .. n over the rows that are there; None if too few are."""
    good = np.isfinite(residual)
    if good.sum() < 10 * lags:
        return None
    r = np.where(good, residual - np.mean(residual[good]), 0.0)
    pairs = np.array([good[:-k] @ good[k:].astype(float) for k in range(1, lags + 1)])
    power = float(r @ r) / float(good.sum())
    return (
        np.array([r[:-k] @ r[k:] for k in range(1, lags + 1)]) / np.maximum(pairs, 1.0) / max(power, 1e-300)
    )


PICTURES = {
    "valve": (valve,),
    "hose": (hose, inertance, capacitance),
    "motor_external": (external,),
    "motor_internal": (internal,),
    "damping": (friction,),
}


def of_session(session: Session) -> tuple[Any, ...]:
    """Return the functions that draw a session."""
    return PICTURES.get(session.name, PICTURES.get(session.name.split("_")[0], ()))
