"""The oil between a hose's inertance and a piston, or a motor's rotor: what it holds, and how it yields.

Hose and chamber are one volume with one pressure. Its state is the pressure, but what a step
conserves is the oil: a flow brings oil, a piston's motion does not.

| symbol | name | unit |
|---|---|---|
| P | pressure in hose and chamber; the tank is at zero | Pa |
| x | actuator position | m; rad |
| V | oil's space in hose and chamber, V_0 + A x | m^3 |
| nu(P) | what a volume holds under pressure over what it holds at tank pressure, 1 + P/beta | 1 |
| C_w | capacitance of the hose's wall | m^3/Pa |
| n | oil in it, as volume at tank pressure, V nu(P) + C_w P | m^3 |
| h(P) | enthalpy of the oil: what a flow brings with it, the integral of dP/nu | J/m^3 |

    dn/dt = Q - leakage + port valves,      C dP/dt = dn/dt - nu A dx/dt,      C = V dnu/dP + C_w

Flows are volumes at tank pressure, so that no oil is lost or made however it is pressed. The
tangent bulk modulus is nu/nu' = beta + P. Of energy the flow brings h dn/dt, the piston takes
P A dx/dt, and the rest is in the volume.

A hose's resistance stands between its inertance and a cylinder's chamber: there is more oil in the
chamber than in the hose, so that what moves with the piston does not pass the hose. For a motor,
whose chambers are small, it stays on the actuator's side (`actuator`). The source is Merritt,
Hydraulic Control Systems, 1967, section 3.1, which takes flows at the pressure in the volume: equal
to first order in P/beta.
"""

import math
from typing import NamedTuple

from forest_description.components.hose import Line


class OilVolume(NamedTuple):
    """Constants of hose and chamber of one port."""

    yields: int  # 0: no chamber, the hose's constant capacitance is all
    volume: float  # V_0 [m^3], at actuator position 0
    area: float  # A = dV/dx [m^2]; 0 for a motor, which takes its oil from the hose
    wall: float  # C_w [m^3/Pa]
    compliance: float  # 1/beta [1/Pa]
    laminar_drop: float  # [Pa s/m^3] of the hose, between inertance and volume
    turbulent_drop: float  # [Pa s^2/m^6]


class StageHose(NamedTuple):
    """A hose as `hydraulic_line.solve_line` takes it: its known part of a stage, and its elements."""

    pressure: float  # [Pa]
    flow: float  # [m^3/s]
    line: Line


NO_CHAMBER = OilVolume(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def space(position: float, v: OilVolume) -> float:
    """Return V [m^3] at an actuator position [m; rad]."""
    return v.volume + v.area * position


def density_ratio(pressure: float, v: OilVolume) -> float:
    """Return nu at a pressure [Pa]."""
    return 1.0 + v.compliance * pressure


def content(pressure: float, position: float, v: OilVolume) -> float:
    """Return n [m^3] at a pressure [Pa] and an actuator position [m; rad]."""
    return space(position, v) * density_ratio(pressure, v) + v.wall * pressure


def capacitance(position: float, v: OilVolume) -> float:
    """Return C = dn/dP [m^3/Pa] at an actuator position [m; rad]."""
    return space(position, v) * v.compliance + v.wall


def enthalpy(pressure: float, v: OilVolume) -> float:
    """Return h [J/m^3] at a pressure [Pa]: beta ln nu, a little less than P."""
    return math.log(density_ratio(pressure, v)) / v.compliance


def stored_energy(pressure: float, position: float, v: OilVolume) -> float:
    """Return the energy [J] of the oil and of the hose's wall, beta C (nu h - P).

    It is C P^2/2 to first order in P/beta.
    """
    pressed = density_ratio(pressure, v) * enthalpy(pressure, v) - pressure
    return capacitance(position, v) * pressed / v.compliance


def hose_drop(flow: float, v: OilVolume) -> float:
    """Return the pressure [Pa] that the hose's resistance takes from a flow [m^3/s] into the volume."""
    return (v.laminar_drop + v.turbulent_drop * abs(flow)) * flow


def stage_hose(
    content: float, flow: float, position: float, line: Line, v: OilVolume, step: float
) -> StageHose:
    """Return a hose with its volume as a hose alone that an implicit stage cannot tell from it.

    The oil is linear in the pressure, so that P = (n - V)/C before the stage's flows. The hose's
    turbulent resistance is taken along its tangent at the flow known; that leaves an error of the
    order of the step's own. A resistance that the flow passes adds `step` times itself to the
    inertance.

    Args:
        content: the stage's known part of n [m^3].
        flow: the stage's known part of Q [m^3/s].
        position: of the actuator at the stage's end [m; rad].
        line: the hose.
        v: its volume.
        step: the stage's implicit step gamma h [s].
    """
    yielding = capacitance(position, v)
    turbulent = step * v.turbulent_drop * abs(flow)
    inertance = line.inertance + step * v.laminar_drop + 2.0 * turbulent
    return StageHose(
        (content - space(position, v)) / yielding,
        flow * (line.inertance + turbulent) / inertance,
        Line(line.resistance, inertance, yielding),
    )
