"""What inertial units on boom and stick tell: attitude by a gyro that accelerometers hold upright.

| symbol | name | unit |
|---|---|---|
| phi | true attitude of the link, above the platform | rad |
| e | what the unit's attitude is off | rad |
| T | time constant of the complementary filter | s |
| a_r, a_z | acceleration of the unit's place: outwards and up, in the crane's plane | m/s^2 |
| alpha | tilt of what is felt: of acceleration less gravity, against the upright | rad |
| b, n_g, n_a | the gyro's bias and noise; the accelerometers' noise over g | rad/s; rad |

The gyro turns the attitude by d phi + (b + n_g) dt. The accelerometers draw it to phi + alpha +
n_a. So the truth cancels, and e' = (alpha + n_a + T (b + n_g) - e)/T: a lag of first order, which is
`sensor_model.sample`'s. The unit reads phi + e. A steady swing at the rate w tilts what a unit feels
at the radius r by alpha = -atan(r w^2/g); a filter that is slower than the motion does not show it.

Accelerations are means over the time between two calls, as of a unit that samples much faster.
Everything here is pure and stays in the subset of Python that `forest_compile.frontend` takes.
"""

import math
from typing import NamedTuple

from forest_sim.equations.plant import PlantState
from forest_sim.sensors.sensor_model import SensorModel

EARTH = 9.81  # [m/s^2] by which the accelerometers' noise is an angle


class Mounting(NamedTuple):
    """Where the units are: lengths of the chain before them, their distances from their joints [m]."""

    base_offset: float = 0.0
    boom_length: float = 0.0
    boom_distance: float = 0.0
    stick_distance: float = 0.0
    gravity: float = EARTH  # [m/s^2]


class UnitSpeeds(NamedTuple):
    """How the units' places move in the crane's plane, outwards and up [m/s]."""

    boom_out: float = 0.0
    boom_up: float = 0.0
    stick_out: float = 0.0
    stick_up: float = 0.0


STANDING = UnitSpeeds()


def unit_speeds(links: PlantState, m: Mounting) -> UnitSpeeds:
    """Return how the units' places move: on the straight lines between the links' ends."""
    boom, stick = links.boom.angle, links.boom.angle + links.stick.angle
    boom_rate, stick_rate = links.boom.rate, links.boom.rate + links.stick.rate
    end_out, end_up = -m.boom_length * math.sin(boom), m.boom_length * math.cos(boom)
    return UnitSpeeds(
        boom_out=-m.boom_distance * math.sin(boom) * boom_rate,
        boom_up=m.boom_distance * math.cos(boom) * boom_rate,
        stick_out=end_out * boom_rate - m.stick_distance * math.sin(stick) * stick_rate,
        stick_up=end_up * boom_rate + m.stick_distance * math.cos(stick) * stick_rate,
    )


def felt_tilts(
    before: UnitSpeeds, now: UnitSpeeds, links: PlantState, m: Mounting, dt: float
) -> tuple[float, float]:
    """Return alpha at boom and stick [rad], `dt` [s] after the units moved as before."""
    boom, stick = links.boom.angle, links.boom.angle + links.stick.angle
    turning = links.swing.rate * links.swing.rate
    boom_radius = m.base_offset + m.boom_distance * math.cos(boom)
    stick_radius = m.base_offset + m.boom_length * math.cos(boom) + m.stick_distance * math.cos(stick)
    return (
        math.atan2(
            (now.boom_out - before.boom_out) / dt - boom_radius * turning,
            (now.boom_up - before.boom_up) / dt + m.gravity,
        ),
        math.atan2(
            (now.stick_out - before.stick_out) / dt - stick_radius * turning,
            (now.stick_up - before.stick_up) / dt + m.gravity,
        ),
    )


def filtered(
    c: SensorModel, attitude: float, tilt: float, normal: float, dt: float
) -> tuple[SensorModel, float]:
    """Return the channel, and the value, of which `sensor_model.sample` makes a unit's reading.

    Args:
        c: the unit; its noise is that of what the filter takes in [rad sqrt(s)].
        attitude: phi [rad].
        tilt: alpha [rad].
        normal: draw from the standard normal distribution.
        dt: time since the last sample [s].
    """
    return c._replace(bias=c.bias + attitude, noise=0.0), tilt + c.noise * normal / math.sqrt(dt)
