"""Plots of an identification's records and fits, as Thesis fig. 4.4, 4.6, 4.8, 4.10 and 4.11.

Measured values are points, fits are dotted lines. Each function draws on axes that it is given.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from forest_description.hydraulics.hose import MeasuredHose
from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_ident.estimators import (
    damping,
    hose_estimators,
    motor_leakage,
    valve_estimate,
)
from forest_ident.experiments import rigs
from forest_ident.measurements.differentiator import derivative, smooth
from forest_ident.measurements.parameter_path import valve_at
from forest_ident.measurements.session import Session
from forest_ident.output_error.residual_test import autocorrelation
from forest_ident.refinement import linear_estimates
from forest_ident.refinement.result import Refined

PERCENTILE = 99.5  # [%] of the samples that a plot's scale must show
MEASURED, FITTED = {"color": "C0"}, {"color": "k", "linestyle": ":", "linewidth": 1.8}
STYLES = ("-", "--", "-.", ":")  # so that no line hides another
NOTHING = np.zeros(0)

Curve = tuple[Floats, Floats]


def _plot(
    axes: Any,
    read: Curve,
    fit: Curve,
    labels: tuple[str, str, str],
    marker: str = ".",
    size: float | None = None,
) -> None:
    """Plot points and a fit; labels: of x, of y, title."""
    axes.plot(*read, marker, markersize=size, label="read", **MEASURED)
    axes.plot(*fit, label="fit", **FITTED)
    axes.set(xlabel=labels[0], ylabel=labels[1], title=labels[2])
    axes.legend()


def valve(axes: Any, machine: Machine, session: Session) -> None:
    """Plot C_R over the voltage: read, law, polynomial. Thesis fig. 4.4."""
    low, high = linear_estimates.floor(machine, session), linear_estimates.highest(machine, session)
    points = valve_estimate.points(session, high)
    c_r = valve_estimate.resistance(points, low)
    order = np.argsort(points.voltage)
    volts, c_r = points.voltage[order], c_r[order]
    section = f"{session.own_axis}.valve" if session.own_axis else "valve"
    one, _ = valve_estimate.flows(valve_at(machine, section), points)
    law = np.where(one != 0.0, points.drop_1 / np.maximum(one**2, 1e-30), math.nan)[order]
    axes.semilogy(volts, c_r, ".", label="read", **MEASURED)
    axes.semilogy(volts, np.where(law < 1e18, law, math.nan), label="law", **FITTED)
    coefficients = valve_estimate.polynomial(volts, c_r)
    seen = np.isfinite(c_r)
    if np.all(np.isfinite(coefficients)):
        curve = np.polynomial.polynomial.polyval(np.abs(volts[seen]), coefficients)
        between = np.searchsorted(volts[seen], 0.0)  # no line through the overlap
        x, y = (np.insert(column, between, math.nan) for column in (volts[seen], curve))
        axes.semilogy(x, np.where(y > 0.0, y, math.nan), "C1--", label="polynomial")
    axes.set(xlabel="voltage, V", ylabel="C_R, Pa s²/m⁶", title="Valve characteristic (fig. 4.4)")
    axes.legend()


def hose(axes: Any, machine: Machine, session: Session) -> None:
    """Plot the pressure drop over the flow. Thesis fig. 4.6."""
    laminar = session.metadata.get("laminar", 0.0) > 0.0
    low, high = linear_estimates.floor(machine, session), linear_estimates.highest(machine, session)
    q, drop = hose_estimators.steady(session, low, high)
    of = machine.hose_of(int(session.metadata.get("hose_axis", 0.0)))
    r = getattr(of, "laminar_resistance" if laminar else "turbulent_resistance", math.nan)
    x = np.linspace(q.min(), q.max(), 100)
    labels = "flow, L/s", "drop, MPa", f"{session.name}: resistance (fig. 4.6)"
    _plot(axes, (1e3 * q, 1e-6 * drop), (1e3 * x, 1e-6 * r * (x if laminar else x * np.abs(x))), labels)


def inertance(axes: Any, machine: Machine, session: Session) -> None:
    """Plot the pressure that accelerates the oil over dQ_1/dt: the slope is I. Thesis fig. 4.8."""
    of, (drop, rate, _, _) = _dynamics(machine, session)
    labels = "dQ_1/dt, m³/s²", "P_in - P_c, MPa", f"{session.name}: inertance (fig. 4.8)"
    _slope(axes, rate, 1e-6 * drop, 1e-6 * of.inertance, labels)


def capacitance(axes: Any, machine: Machine, session: Session) -> None:
    """Plot the flow that stays in the hose over dP_c/dt: the slope is C. Thesis fig. 4.8."""
    of, (_, _, difference, rate) = _dynamics(machine, session)
    labels = "dP_c/dt, GPa/s", "Q_1 - Q_2, L/s", f"{session.name}: capacitance (fig. 4.8)"
    _slope(axes, 1e-9 * rate, 1e3 * difference, 1e12 * of.capacitance, labels)


def _dynamics(machine: Machine, session: Session) -> tuple[MeasuredHose, tuple[Floats, ...]]:
    """Return the hose, and every fifth row of the terms of its equations."""
    laminar = session.metadata.get("laminar", 0.0) > 0.0
    of = rigs.as_measured(machine, machine.hose_of(int(session.metadata.get("hose_axis", 0.0))))
    r = of.laminar_resistance if laminar else of.turbulent_resistance
    meter = linear_estimates.meter(machine, session)
    lag = meter.time_constant if meter else 0.0
    *terms, rows = hose_estimators.terms(session, r, laminar, lag)
    part = slice(rows.start, rows.stop, 5)
    return of, tuple(term[part] for term in terms)


def _slope(axes: Any, x: Floats, y: Floats, slope: float, labels: tuple[str, str, str]) -> None:
    """Plot points and a line through zero; the scale leaves out the jumps between two samples."""
    ends = np.percentile(np.abs(x), PERCENTILE) * np.array([-1.0, 1.0])
    _plot(axes, (x, y), (ends, slope * ends), labels, size=3)
    axes.set(xlim=1.1 * ends, ylim=1.3 * slope * ends)


def external_leakage(axes: Any, machine: Machine, session: Session) -> None:
    """Plot the case drain over the sum of the pressures. Thesis fig. 4.10."""
    one, two = session.pressures("swing", "actuator")
    x = smooth((one + two) * motor_leakage.viscosity_factor(machine, session), 2.0, session.period)
    read = (NOTHING, NOTHING)
    if session.has("case_drain"):
        read = (1e-6 * x[::20], 6e4 * smooth(session.column("case_drain"), 2.0, session.period)[::20])
    knots = np.array([0.0, float(x.max())])
    fit = (1e-6 * knots, 6e4 * knots / machine.swing.external_leakage_resistance)
    _plot(axes, read, fit, ("P_1 + P_2, MPa", "case drain, L/min", "External leakage (fig. 4.10)"), size=2)


def internal_leakage(axes: Any, machine: Machine, session: Session) -> None:
    """Plot the flow between the motor's ports over the pressure difference. Thesis fig. 4.10."""
    period, f = session.period, motor_leakage.viscosity_factor(machine, session)
    displacement = machine.swing.gear_ratio * machine.swing.motor_displacement
    band = motor_leakage.BANDWIDTH
    speed = np.abs(derivative(session.column("swing_resolver"), band, period))
    one, two = (smooth(column, band, period) for column in session.pressures("swing", "actuator"))
    high = np.maximum(one, two)
    inside = displacement * speed - f * high / machine.swing.external_leakage_resistance
    x = f * (high - np.minimum(one, two))
    rows = slice(round(6.0 / period), -round(4.0 / period), 20)
    knots = np.array([float(x[rows].min()), float(x[rows].max())])
    fit = (1e-6 * knots, 6e4 * knots / machine.swing.internal_leakage_resistance)
    labels = "P_1 - P_2, MPa", "internal leakage, L/min", "Internal leakage (fig. 4.10)"
    _plot(axes, (1e-6 * x[rows], 6e4 * inside[rows]), fit, labels, size=2)


def friction(axes: Any, machine: Machine, session: Session) -> None:
    """Plot the force that the load does not take over the speed. Thesis fig. 4.11."""
    axis = AXES.index(session.own_axis)
    alpha, speed, *_ = damping.equation(machine, session, axis)
    order = np.argsort(speed)
    units = ("rad/s", "kN m") if axis == 0 else ("m/s", "kN")
    read = (speed[order], 1e-3 * alpha[order])
    fit = (speed[order], 1e-3 * machine.drives[axis].damping * speed[order])
    _plot(axes, read, fit, (f"speed, {units[0]}", units[1], f"Damping, {AXES[axis]} (fig. 4.11)"), ",")


def whiteness(axes: Any, refined: Refined) -> None:
    """Plot the autocorrelation of the refinement's residuals, with the band of white noise."""
    count = 0
    for name, residual in refined.fit.residuals.items():
        r = autocorrelation(residual)
        if r is not None:
            style = STYLES[len(axes.lines) % len(STYLES)]
            axes.plot(np.arange(1, len(r) + 1), r, style, linewidth=0.8, label=name)
            count = max(count, int(np.isfinite(residual).sum()))
    band = 1.96 / math.sqrt(max(count, 1))
    axes.axhspan(-band, band, color="0.85")
    axes.set(
        xlabel="lag, samples of the sensor",
        ylim=(-0.3, 1.0),
        title=f"{refined.session.name}: residuals' correlation",
    )
    axes.legend(fontsize=5)


PLOTS: dict[str, tuple[Callable[[Any, Machine, Session], None], ...]] = {
    "valve": (valve,),
    "hose": (hose, inertance, capacitance),
    "motor_external": (external_leakage,),
    "motor_internal": (internal_leakage,),
    "damping": (friction,),
}


def of_session(session: Session) -> tuple[Callable[[Any, Machine, Session], None], ...]:
    """Return the functions that plot a session."""
    return PLOTS.get(session.name, PLOTS.get(session.kind, ()))
