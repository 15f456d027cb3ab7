"""Up to which amplitude oil with air, behind shut valves, is the spring that it is at rest.

| symbol | name | unit |
|---|---|---|
| X | amplitude of the actuator's position | m; rad |
| F(x) | force of the shut oil over that at rest; its own sign is against x | N; N m |
| c | centre of the swing, on the softer side: there the mean of F vanishes | m; rad |
| k(X) | stiffness of the spring that takes as much of a sine of that amplitude | N/m; N m/rad |

    k(X) = -1/(pi X) integral over a period of F(c + X sin t) sin t dt        (describing function)

Linearised at rest the oil has k(0). A swing that brings a side near tank pressure finds bubbles there.
"""

import math

from forest_description.types import AXES
from forest_sim.equations.plant import AxisState, Transmission, at_joints, transmissions
from forest_sim.equations.plant_parameters import Axis, PlantParameters
from forest_sim.hydraulics.oil_volume import OilVolume, content, settled_pressure
from forest_sim.solver.integrator import Simulation

SAMPLES = 40  # of half a sine
SINES = tuple(math.sin(math.pi * ((k + 0.5) / SAMPLES - 0.5)) for k in range(SAMPLES))
SMALLEST, GREATEST = 1e-6, 1.0  # [m; rad] amplitudes that are looked at, each twice the last
HALVINGS = 8  # of the last doubling
CENTRED, CENTRINGS = 1e-3, 60  # of X to which c is found, and in how many steps at most
WITHIN = 0.1  # of k(0), a twentieth of the frequency


def stiffness(amplitude: float, state: AxisState, t: Transmission, axis: Axis) -> float:
    """Return k(X).

    Args:
        amplitude: X, above zero [m; rad].
        state: the axis at rest.
        t: its actuator there.
        axis: its parameters.
    """
    slope, centre = -_force(1e-3 * SMALLEST, state, t, axis) / (1e-3 * SMALLEST), 0.0
    for _ in range(CENTRINGS):
        forces = [_force(centre + amplitude * sine, state, t, axis) for sine in SINES]
        off = sum(forces) / (SAMPLES * slope)
        centre += off
        if abs(off) < CENTRED * amplitude:
            break
    return -2.0 * sum(f * sine for f, sine in zip(forces, SINES, strict=True)) / (SAMPLES * amplitude)


def _force(x: float, state: AxisState, t: Transmission, axis: Axis) -> float:
    """Return F [N; N m] at a position from that at rest [m; rad]."""
    a, at = axis.actuator, t.position
    one = _rise(state.pressure_1, a.displacement_1, x, at, axis.oil_1)
    return a.displacement_1 * one - a.displacement_2 * _rise(
        state.pressure_2, -a.displacement_2, x, at, axis.oil_2
    )


def _rise(pressure: float, displaced: float, x: float, position: float, v: OilVolume) -> float:
    """Return by how much a shut volume's pressure [Pa] is above that at rest."""
    oil = content(pressure, position, v).oil
    left = oil if v.area != 0.0 else oil - displaced * x  # else its room grows with x
    return settled_pressure(pressure, left, position + x, v) - pressure


def amplitudes(point: Simulation, p: PlantParameters) -> dict[str, float]:
    """Return up to which amplitude X each axis' oil is within a tenth of its spring at rest; {}: without air.

    Args:
        point: the machine at rest.
        p: its parameters.
    """
    plant = at_joints(point.plant, p)
    at = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
    return {
        name: _held(state, t, axis)
        for name, state, t, axis in zip(AXES, plant.axes, at, p.axes, strict=True)
        if axis.oil_1.oil.air > 0.0
    }


def _held(state: AxisState, t: Transmission, axis: Axis) -> float:
    first = stiffness(SMALLEST, state, t, axis)

    def holds(amplitude: float) -> bool:
        return abs(stiffness(amplitude, state, t, axis) / first - 1.0) <= WITHIN

    high = SMALLEST
    while holds(high):
        high *= 2.0
        if high > GREATEST:
            return math.inf
    low = 0.5 * high
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def heading(found: dict[str, float]) -> str:
    """Return in words up to where the oil's springs hold."""
    told = ", ".join(
        f"{name} {1e3 * amplitude:.2g} {'mrad' if name == 'swing' else 'mm'}"
        for name, amplitude in found.items()
    )
    return f"oil with air: its springs are within a tenth of those at rest for amplitudes up to {told}"
