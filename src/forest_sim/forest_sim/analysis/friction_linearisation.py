"""Dry friction in a linear model: for which oscillations it is a damper, and for which it may be left out.

| symbol | name | unit |
|---|---|---|
| U | amplitude of the piston's speed | m/s |
| c(U) | viscous damping that takes as much energy from a sine of that amplitude | N s/m |
| u_0 | speed under which the sign of the friction is smoothed | m/s |
| B | viscous friction of the cylinder | N s/m |

    c(U) = 1/(pi U) integral over a period of F(U sin t) sin t dt        (describing function)

c falls from the slope dF/du at rest towards zero. A linearisation about rest has the slope: it is
for small oscillations, in which the seals stick. Large oscillations hardly feel the dry friction.
About a steady motion the slope is that at its speed, and the same amplitudes hold.
"""

import math
from typing import NamedTuple

from forest_description.types import AXES
from forest_sim.mechanics.friction import FRICTIONLESS, Friction, friction_force
from forest_sim.solver.plant_parameters import PlantParameters

SMALL = 0.5  # U/u_0 up to which c(U) is within 10 % of the slope at rest
SAMPLES = 400  # of a quarter of the sine
FASTEST = 100.0  # [m/s] no piston is


class AmplitudeLimits(NamedTuple):
    """Amplitudes of a piston's speed between which neither linear model holds [m/s]."""

    small: float  # below: the friction is a damper of the slope at rest
    large: float  # above: it takes less than viscous friction does; infinite if there is none of that


def equivalent_damping(amplitude: float, f: Friction) -> float:
    """Return c(U) [N s/m] of a sine with an amplitude of speed above zero [m/s], by the midpoint rule."""
    if f.breakaway == 0.0:
        return 0.0
    sines = (math.sin(0.5 * math.pi * (k + 0.5) / SAMPLES) for k in range(SAMPLES))
    return 2.0 * sum(friction_force(amplitude * s, f) * s for s in sines) / (SAMPLES * amplitude)


def amplitude_limits(f: Friction, viscous: float) -> AmplitudeLimits:
    """Return where the two linear models of a cylinder end.

    Args:
        f: its dry friction.
        viscous: B [N s/m].
    """
    small = SMALL * f.smoothing_speed
    if equivalent_damping(FASTEST, f) > viscous:
        return AmplitudeLimits(small, math.inf)
    low, high = small, FASTEST
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if equivalent_damping(middle, f) > viscous else (low, middle)
    return AmplitudeLimits(small, high)


def axes_with_friction(p: PlantParameters) -> dict[str, AmplitudeLimits]:
    """Return the ends of each axis that has dry friction, by its name."""
    return {
        name: amplitude_limits(axis.friction, axis.actuator.damping)
        for name, axis in zip(AXES, p.axes, strict=True)
        if axis.friction.breakaway > 0.0
    }


def without_dry_friction(p: PlantParameters) -> PlantParameters:
    """Return the parameters with every axis' dry friction left out."""
    return p.with_axes(friction=FRICTIONLESS)


def small_heading(ends: dict[str, AmplitudeLimits]) -> str:
    """Return in words what a table of small oscillations is for."""
    speeds = ", ".join(f"{name} {1e3 * end.small:.3g} mm/s" for name, end in ends.items())
    return f"small oscillations: dry friction as the damper that its slope is; piston speeds below {speeds}"


def large_heading(ends: dict[str, AmplitudeLimits]) -> str:
    """Return in words what a table of large oscillations is for."""
    speeds = ", ".join(
        f"{name} {1e3 * end.large:.3g} mm/s" if math.isfinite(end.large) else f"{name} never"
        for name, end in ends.items()
    )
    return (
        "large oscillations: without dry friction, which takes less energy than viscous friction does "
        f"at piston speeds above {speeds}"
    )
