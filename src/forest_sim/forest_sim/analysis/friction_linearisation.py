"""Dry friction and play in a linear model: what they are to small oscillations, when they may be left out.

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

A bearing that sticks is a spring up to the angle z_e that its bristles only bend. A gear with play
holds nothing within b to either side. Its describing function, 1 - 2/pi (asin r + r sqrt(1 - r^2))
with r = b/A, is 0.9 of the teeth's stiffness at an amplitude A of 12.7 b.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from forest_description.types import AXES
from forest_sim.equations.plant import PlantState
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.mechanics.bristles import NO_BRISTLES, sliding_friction
from forest_sim.mechanics.friction import FRICTIONLESS, Friction, friction_force, pressed
from forest_sim.mechanics.gear import without_play

SMALL = 0.5  # U/u_0 up to which c(U) is within 10 % of the slope at rest
SAMPLES = 400  # of a quarter of the sine
SINES = tuple(math.sin(0.5 * math.pi * (k + 0.5) / SAMPLES) for k in range(SAMPLES))
FASTEST = 100.0  # [m/s] no piston is
PLAYED = 12.7  # A/b from which play takes less than a tenth of the teeth's stiffness
STANDSTILL = 1e-9  # [rad/s] no swing is slower than that


class AmplitudeLimits(NamedTuple):
    """Amplitudes of a piston's speed between which neither linear model holds [m/s]."""

    small: float  # below: the friction is a damper of the slope at rest
    large: float  # above: it takes less than viscous friction does; infinite if there is none of that


def equivalent_damping(amplitude: float, f: Friction) -> float:
    """Return c(U) [N s/m] of a sine with an amplitude of speed above zero [m/s], by the midpoint rule."""
    return 0.0 if f.breakaway == 0.0 else _damping_of(lambda u: friction_force(u, f), amplitude)


def _damping_of(friction: Callable[[float], float], amplitude: float) -> float:
    return 2.0 * sum(friction(amplitude * s) * s for s in SINES) / (SAMPLES * amplitude)


def amplitude_limits(f: Friction, viscous: float) -> AmplitudeLimits:
    """Return where the two linear models of a cylinder end.

    Args:
        f: its dry friction.
        viscous: B [N s/m].
    """
    small = SMALL * f.smoothing_speed
    return AmplitudeLimits(small, _fast(lambda u: equivalent_damping(u, f), viscous, small))


def _fast(damping: Callable[[float], float], viscous: float, low: float) -> float:
    """Return the amplitude of speed from which a damping is below the viscous one; infinite if none."""
    if damping(FASTEST) > viscous:
        return math.inf
    high = FASTEST
    for _ in range(60):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if damping(middle) > viscous else (low, middle)
    return high


def with_pressed_seals(p: PlantParameters, state: PlantState) -> PlantParameters:
    """Return the parameters with the seals' friction as it is at a state's pressures, at any others."""
    swing, boom, stick = (
        axis._replace(friction=pressed(axis.friction, s.pressure_1, s.pressure_2))
        for axis, s in zip(p.axes, state.axes, strict=True)
    )
    return p._replace(swing=swing, boom=boom, stick=stick)


def axes_with_friction(p: PlantParameters) -> dict[str, AmplitudeLimits]:
    """Return the ends of each axis that has dry friction, by its name; see `with_pressed_seals`."""
    return {
        name: amplitude_limits(axis.friction, axis.actuator.damping)
        for name, axis in zip(AXES, p.axes, strict=True)
        if axis.friction.breakaway > 0.0
    }


class DriveLimits(NamedTuple):
    """Amplitudes of the swing between which neither linear model holds."""

    small: float  # [rad] below: the bearing is a spring, and the teeth do not touch
    large: float  # [rad] above: play counts for less than a tenth
    fast: float  # [rad/s] above: the bearing takes less energy than viscous friction does


def drive_limits(p: PlantParameters) -> DriveLimits | None:
    """Return where the two linear models of the swing end; None without play and bearing friction."""
    b, teeth = p.drive.bearing, p.drive.gear.teeth
    if not p.drive.present:
        return None
    play = teeth.upper if p.drive.gear.inertia > 0.0 else 0.0
    if b.stiffness == 0.0:
        return DriveLimits(play, PLAYED * play, 0.0)
    viscous = p.swing.actuator.damping
    fast = _fast(lambda u: _damping_of(lambda v: sliding_friction(v, b), u), viscous, STANDSTILL)
    return DriveLimits(min(b.elastic, play) if play > 0.0 else b.elastic, PLAYED * play, fast)


def is_rough(p: PlantParameters) -> bool:
    """Tell whether small oscillations differ from large ones."""
    return any(axis.friction.breakaway > 0.0 for axis in p.axes) or p.drive.present != 0


def without_dry_friction(p: PlantParameters) -> PlantParameters:
    """Return the parameters with every axis' dry friction left out, and the gear's play."""
    drive = p.drive._replace(bearing=NO_BRISTLES, gear=without_play(p.drive.gear))
    return p.with_axes(friction=FRICTIONLESS)._replace(drive=drive)


def small_heading(p: PlantParameters) -> str:
    """Return in words what a table of small oscillations is for."""
    ends, swing, told = axes_with_friction(p), drive_limits(p), []
    if ends:
        speeds = ", ".join(f"{name} {1e3 * end.small:.3g} mm/s" for name, end in ends.items())
        told.append(f"dry friction as the damper that its slope is; piston speeds below {speeds}")
    if swing is not None:
        told.append(
            f"a bearing that sticks, teeth that do not touch; swing angles below {1e3 * swing.small:.3g} mrad"
        )
    return f"small oscillations: {'; '.join(told)}"


def large_heading(p: PlantParameters) -> str:
    """Return in words what a table of large oscillations is for."""
    ends, swing, told = axes_with_friction(p), drive_limits(p), []
    if ends:
        speeds = ", ".join(f"{name} {_speed(end.large, 'mm/s')}" for name, end in ends.items())
        told.append(
            "without dry friction, which takes less energy than viscous friction does "
            f"at piston speeds above {speeds}"
        )
    if swing is not None:
        told.append(
            f"without play and bearing friction; swing angles above {1e3 * swing.large:.3g} mrad, "
            f"rates above {_speed(swing.fast, 'mrad/s')}"
        )
    return f"large oscillations: {'; '.join(told)}"


def _speed(speed: float, unit: str) -> str:
    return f"{1e3 * speed:.3g} {unit}" if math.isfinite(speed) else "never"
