"""Priors of an actuator's parameters, and their units.

Positive parameters are log-normal about a centre, the others normal: with some thirty parameters and one
record of a few motions, least squares alone explains the record and nothing after it. Centres are of the
order that a load-sensing crane valve and a cylinder of usual proportions give once valve, pressure and
position are brought to the spans of `record.SPANS`; widths of 0.5 to 1 allow a factor of 3 to 7.
Centres and widths were chosen by cross-validation within the first half of a record (docs/real-crane.md).
"""

import math
from typing import NamedTuple

from forest_ident.actuator.model import Parameters


class Prior(NamedTuple):
    """One parameter: name, centre, width (relative if positive), powers of V, P, X and n in its unit."""

    name: str
    centre: float
    width: float
    unit: tuple[int, int, int, int]
    positive: bool = True


_CONDUCTANCE = (-1, 0, 1, -1)  # and P^-1/2, see `unit_factor`
PRIORS = (
    Prior("dead_time", 1.5, 0.5, (0, 0, 0, 1)),
    Prior("spool_lag", 1.0, 0.7, (0, 0, 0, 1)),
    Prior("deadband_extend", 0.04, 0.5, (1, 0, 0, 0)),
    Prior("deadband_retract", 0.04, 0.5, (1, 0, 0, 0)),
    Prior("meter_in_extend", 0.04, 0.8, _CONDUCTANCE),
    Prior("meter_in_retract", 0.02, 0.8, _CONDUCTANCE),
    Prior("meter_out_extend", 0.03, 0.8, _CONDUCTANCE),
    Prior("meter_out_retract", 0.03, 0.8, _CONDUCTANCE),
    Prior("flow_limit_extend", 0.0195, 0.2, (0, 0, 1, -1)),
    Prior("flow_limit_retract", 0.04, 0.3, (0, 0, 1, -1)),
    Prior("pump_lag", 5.0, 0.6, (0, 0, 0, 1)),
    Prior("pump_margin", 1.5, 0.7, (0, 1, 0, 0)),
    Prior("rest_pressure_1", 5.0, 0.4, (0, 1, 0, 0)),
    Prior("rest_pressure_2", 0.5, 0.7, (0, 1, 0, 0)),
    Prior("area_ratio", 0.5, 0.35, (0, 0, 0, 0)),
    Prior("capacitance_1", 0.009, 0.7, (0, -1, 1, 0)),
    Prior("capacitance_2", 0.004, 0.7, (0, -1, 1, 0)),
    Prior("capacitance_slope", 0.0, 0.1, (0, 0, -1, 0), positive=False),
    Prior("hose_resistance", 500.0, 0.8, (0, 1, -2, 2)),
    Prior("mass", 60.0, 1.0, (0, 1, -1, 2)),
    Prior("damping", 16.0, 0.5, (0, 1, -1, 1)),
    Prior("friction_extend", 0.05, 1.0, (0, 1, 0, 0)),
    Prior("friction_retract", 0.05, 1.0, (0, 1, 0, 0)),
    Prior("gravity_slope", 0.0, 0.1, (0, 1, -1, 0), positive=False),
    Prior("arm_stiffness", 36.0, 0.5, (0, 1, -1, 0)),
    Prior("arm_damping", 8.0, 1.0, (0, 1, -1, 1)),
    Prior("arm_mass", 370.0, 0.5, (0, 1, -1, 2)),
    Prior("load_stiffness", 0.6, 1.0, (0, 1, -1, 0)),
    Prior("load_damping", 0.1, 1.0, (0, 1, -1, 1)),
    Prior("load_mass", 16.0, 0.7, (0, 1, -1, 2)),
    Prior("sensed_share", 0.15, 0.2, (0, 0, 0, 0), positive=False),
)


class Actuator(NamedTuple):
    """What is fitted: the dead time before the spool [n], and the rest."""

    dead_time: float
    parameters: Parameters


def actuator(z: list[float]) -> Actuator:
    """Return the actuator of a point in the space of the fit (logarithms of what is positive)."""
    values = {p.name: math.exp(min(at, 30.0)) if p.positive else at for p, at in zip(PRIORS, z, strict=True)}
    return Actuator(values.pop("dead_time"), Parameters(**values))


def centre() -> list[float]:
    """Return the middle of the priors in the space of the fit."""
    return [math.log(p.centre) if p.positive else p.centre for p in PRIORS]


def unit_factor(prior: Prior, valve: float, pressure: float, position: float) -> float:
    """Return by what a value is multiplied to stand in the record's units."""
    v, p, x, _ = prior.unit
    half = -0.5 if prior.unit == _CONDUCTANCE else 0.0
    return float(abs(valve) ** v * pressure ** (p + half) * position**x)


def unit(prior: Prior) -> str:
    """Return a parameter's unit in words of the record: valve, pressure, position, sample."""
    powers = list(zip(("valve", "pressure", "position", "sample"), map(float, prior.unit), strict=True))
    if prior.unit == _CONDUCTANCE:
        powers[1] = ("pressure", -0.5)
    return " ".join(name if k == 1 else f"{name}^{k:g}" for name, k in powers if k != 0) or "1"
