"""The oil between a hose's inertance and a piston, or a motor's rotor: what it holds, and how it yields.

Hose and chamber are one volume with one pressure. Its state is the pressure, but what a step
conserves is the oil: a flow brings oil, a piston's motion does not.

| symbol | name | unit |
|---|---|---|
| P | pressure in hose and chamber; the tank is at zero | Pa |
| x | actuator position | m; rad |
| V | room for oil in hose and chamber, V_0 + A x + C_w P | m^3 |
| C_w | capacitance of the hose's wall | m^3/Pa |
| nu(P) | density over that at tank pressure (`oil_law`) | 1 |
| h(P) | enthalpy of the oil (`oil_law`) | J/m^3 |
| n | oil in it, as volume at tank pressure, V nu | m^3 |

    dn/dt = Q - leakage + port valves,      C dP/dt = dn/dt - nu A dx/dt,      C = V dnu/dP + C_w nu

Flows are volumes at tank pressure, so that no oil is lost or made however it is pressed. Of energy
the flow brings h dn/dt, the piston takes P A dx/dt, and the rest is in the volume.

A motor takes volumes at tank pressure, too, unless its inlet is near vapour: it then takes the oil
that is in the room that it opens, nu/0.95 of it, and runs an emptied volume no further down.

A hose's resistance stands between its inertance and the volume: there is more oil in a chamber than
in the hose, so that what moves with the piston does not pass the hose, and the actuator's port has
the volume's pressure, which no vacuum is below. The source is Merritt, Hydraulic Control Systems,
1967, section 3.1, which takes flows at the pressure in the volume: equal to first order in P/beta.
"""

from typing import NamedTuple

from forest_description.hydraulics.hose import Line
from forest_sim.hydraulics.oil_law import INCOMPRESSIBLE, OilLaw, density, enthalpy, held_above_vapour

SETTLED = 1e-9  # of the oil in a volume, from which Newton's next step is its last: it squares that
SETTLING_STEPS = 60
BUBBLY = 0.95  # nu below which a motor's room is not full: 10 kPa of absolute pressure with 0.5 % of air


class OilVolume(NamedTuple):
    """Constants of hose and chamber of one port."""

    yields: int  # 0: the hose's constant capacitance is all
    volume: float  # V_0 [m^3], at actuator position 0
    area: float  # A [m^2]; 0 for a motor, which takes its oil from the hose
    wall: float  # C_w [m^3/Pa]
    laminar_drop: float  # [Pa s/m^3] of the hose, between inertance and volume
    turbulent_drop: float  # [Pa s^2/m^6]
    oil: OilLaw


class StageHose(NamedTuple):
    """A hose as `hydraulic_line.solve_line` takes it: its known part of a stage, and its elements."""

    pressure: float  # [Pa]
    flow: float  # [m^3/s]
    line: Line
    density: float = 1.0  # nu of the oil that a piston takes


class Content(NamedTuple):
    """What a volume holds at a pressure."""

    oil: float  # n [m^3]
    capacitance: float  # C = dn/dP [m^3/Pa]
    density: float  # nu


NO_CHAMBER = OilVolume(0, 0.0, 0.0, 0.0, 0.0, 0.0, INCOMPRESSIBLE)


def content(pressure: float, position: float, v: OilVolume) -> Content:
    """Return n and C at a pressure [Pa] and an actuator position [m; rad]."""
    space, nu = v.volume + v.area * position + v.wall * pressure, density(pressure, v.oil)
    return Content(space * nu.ratio, v.wall * nu.ratio + space * nu.slope, nu.ratio)


def filled_share(speed: float, pressure_1: float, pressure_2: float, v: OilVolume) -> float:
    """Return which share of the room that a motor opens its inlet fills with oil; 1 of a piston.

    Args:
        speed: of the actuator [rad/s].
        pressure_1: P of port 1, the inlet where the speed is positive [Pa].
        pressure_2: of port 2 [Pa].
        v: a volume of the actuator; both hold the same oil.
    """
    if v.area != 0.0 or v.oil.air == 0.0:
        return 1.0
    inlet = pressure_1 if speed > 0.0 else pressure_2
    return min(1.0, max(0.0, density(inlet, v.oil).ratio / BUBBLY))


def stored_energy(pressure: float, position: float, v: OilVolume) -> float:
    """Return the energy [J] of the oil and of the hose's wall, V (nu h - P) + C_w P^2/2."""
    space = v.volume + v.area * position + v.wall * pressure
    pressed = enthalpy(pressure, v.oil) * density(pressure, v.oil).ratio - pressure
    return space * pressed + 0.5 * v.wall * pressure * pressure


def hose_drop(flow: float, v: OilVolume) -> float:
    """Return the pressure [Pa] that the hose's resistance takes from a flow [m^3/s] into the volume."""
    return (v.laminar_drop + v.turbulent_drop * abs(flow)) * flow


def stage_hose(
    oil: float, flow: float, position: float, near: float, line: Line, v: OilVolume, step: float
) -> StageHose:
    """Return a hose with its volume as a hose alone that an implicit stage cannot tell from it.

    What the volume holds is taken along its tangent at a pressure near the stage's, and the hose's
    turbulent resistance along its tangent at the flow known, which leaves an error of the order of
    the step's own. A resistance that the flow passes adds `step` times itself to the inertance.

    Args:
        oil: the stage's known part of n [m^3].
        flow: the stage's known part of Q [m^3/s].
        position: of the actuator at the stage's end [m; rad].
        near: the pressure of the tangent [Pa].
        line: the hose.
        v: its volume.
        step: the stage's implicit step gamma h [s].
    """
    there = content(near, position, v)
    turbulent = step * v.turbulent_drop * abs(flow)
    inertance = line.inertance + step * v.laminar_drop + 2.0 * turbulent
    return StageHose(
        near + (oil - there.oil) / there.capacitance,
        flow * (line.inertance + turbulent) / inertance,
        Line(line.resistance, inertance, there.capacitance),
        there.density,
    )


def settled_pressure(near: float, oil: float, position: float, v: OilVolume) -> float:
    """Return the pressure [Pa] at which a volume holds n [m^3], found from one near it."""
    pressure = near
    for _ in range(SETTLING_STEPS):
        there = content(pressure, position, v)
        off = there.oil - oil
        pressure = held_above_vapour(pressure - off / there.capacitance, pressure, v.oil)
        if abs(off) <= SETTLED * oil:
            break
    return pressure
