"""Errors of a model's prediction of a record that it was not fitted to. Thesis section 4.4.

| symbol | name |
|---|---|
| y, yhat | measured, predicted; both smoothed alike where a speed is made of angles |
| NRMSE | RMS of y - yhat over the range of y |
| VAF | 1 - var(y - yhat)/var(y), variance accounted for |
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from forest_description.machine import Machine
from forest_description.types import AXES, Floats
from forest_ident.estimators import calibration
from forest_ident.measurements.differentiator import derivative
from forest_ident.measurements.session import Session, SessionError
from forest_ident.output_error.prediction import predict
from forest_ident.refinement import data_quality, refinement

SPEED_BANDWIDTH = 8.0  # [Hz] of the smoothing of both speeds
LIMITS = {"angle": 0.02, "velocity": 0.05, "flow": 0.05, "pressure": 0.1}
"""Greatest NRMSE of a record that a model predicts; pressures bear more than motion."""
STILL = 1e-6  # [unit] range of a signal that did not move


def rms(values: Floats) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


class Signal(NamedTuple):
    """One signal of an axis, measured and predicted."""

    axis: str
    name: str  # angle, velocity, flow, driving pressure, return pressure
    unit: str
    measured: Floats
    predicted: Floats

    @property
    def nrmse(self) -> float:
        """RMS error over range."""
        return rms(self.measured - self.predicted) / max(float(np.ptp(self.measured)), STILL)

    @property
    def vaf(self) -> float:
        """Variance accounted for."""
        variance = max(float(np.var(self.measured)), STILL**2)
        return 1.0 - float(np.var(self.measured - self.predicted)) / variance


def signals(model: Machine, session: Session) -> list[Signal]:
    """Return the signals of the axes that moved: angle, velocity, flow where a meter is, both pressures.

    Args:
        model: that predicts.
        session: of the crane, held out.

    Raises:
        SessionError: it is a rig's record, or too short, or has no angles.
    """
    if not session.on_crane:
        raise SessionError(f"{session.name}: allowed for validation: records of the crane, not of a rig")
    missing = [f"{axis}_resolver" for axis in AXES if not session.has(f"{axis}_resolver")]
    if missing or len(session.time) < 100:
        raise SessionError(f"{session.name}: too short, or without {', '.join(missing) or 'samples'}")
    columns = predict(refinement.prepared(model, session), calibration.corrected(session, model))
    columns = columns if session.is_exact else calibration.as_read(columns, model)
    found: list[Signal] = []
    for axis in AXES:
        if np.ptp(session.column(f"{axis}_resolver")) > 0.02:
            found += _axis(axis, session, columns)
    if not found:
        raise SessionError(f"{session.name}: no axis moved; it takes a record with motion")
    return found


def predicted(model: Machine, session: Session) -> list[Signal]:
    """Return the signals as `signals` does; none of a record that cannot be predicted."""
    try:
        with data_quality.evaluated(session):
            return signals(model, session)
    except SessionError:
        return []


def _axis(axis: str, session: Session, predicted: dict[str, Floats]) -> list[Signal]:
    angle = session.column(f"{axis}_resolver"), predicted[f"{axis}_resolver"]
    rates = tuple(derivative(column, SPEED_BANDWIDTH, session.period) for column in angle)
    found = [
        Signal(axis, "angle", "rad", *angle),
        Signal(axis=axis, name="velocity", unit="rad/s", measured=rates[0], predicted=rates[1]),
    ]
    if session.has(f"{axis}_flow"):
        flow, exact = session.column(f"{axis}_flow"), predicted[f"{axis}_flow"]
        floor = float(np.min(np.abs(flow)))  # what the meter shows at rest
        shown = np.where(exact < 0.0, -1.0, 1.0) * np.maximum(np.abs(exact), floor)
        signs = np.sign(flow) != np.sign(shown)
        still = signs & (np.abs(flow) <= 1.001 * floor) & (np.abs(shown) <= 1.001 * floor)
        found.append(
            Signal(axis=axis, name="flow", unit="m3/s", measured=flow, predicted=np.where(still, flow, shown))
        )
    there = [port for port in (1, 2) if session.has(f"{axis}_pressure_{port}_actuator")]
    return found + [_pressure(axis, port, session, predicted) for port in there]


def _pressure(axis: str, port: int, session: Session, predicted: dict[str, Floats]) -> Signal:
    channel = f"{axis}_pressure_{port}_actuator"
    measured = session.column(channel)
    shown = np.maximum(predicted[channel], 0.0) if measured.min() >= 0.0 else predicted[channel]
    return Signal(axis=axis, name=f"pressure {port}", unit="Pa", measured=measured, predicted=shown)


def limit(signal: Signal) -> float:
    """Return the greatest NRMSE at which a signal counts as predicted."""
    return LIMITS[signal.name.partition(" ")[0]]


def is_missed(signal: Signal) -> bool:
    """Tell whether a signal is not predicted; so is one whose error is no number."""
    return not signal.nrmse <= limit(signal)


def over_limit(found: Sequence[Signal]) -> list[str]:
    """Return a text on every signal that is not predicted."""
    return [
        f"{s.axis} {s.name} is {100.0 * s.nrmse:.1f} % off, limit {100.0 * limit(s):.0f} %"
        for s in found
        if is_missed(s)
    ]


def text_table(found: Sequence[Signal]) -> str:
    """Return NRMSE with its limit, and VAF, per signal."""
    lines = ["| signal | NRMSE, % | limit, % | VAF, % |", "|---|---|---|---|"]
    scores = (
        f"| {s.axis} {s.name} | {100.0 * s.nrmse:.2f} | "
        f"{100.0 * limit(s):.0f}{' missed' * is_missed(s)} | {100.0 * s.vaf:.2f} |"
        for s in found
    )
    return "\n".join([*lines, *scores])
