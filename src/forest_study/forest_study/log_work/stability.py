"""How far the vehicle is from tipping over a wheel line, by the weights alone.

The simulator's chassis stands still. So the margin is a static sum of moments about the wheel line on the
crane's side, with the chassis' numbers of `site`: what holds the vehicle less what tips it, over what holds
it. It is 1 with the crane over the middle and 0 where the far wheels lift. Accelerations are left out.
"""

import numpy as np

from forest_description.mechanics.manipulator import Manipulator
from forest_description.types import Floats
from forest_study.log_work.site import Site


def margin(m: Manipulator, site: Site, angles: Floats, log_mass: Floats) -> Floats:
    """Return the margin over time [N] of the nearer wheel line.

    Args:
        m: masses and centres of the crane.
        site: chassis and track.
        angles: of swing, boom, stick [N, 3] rad.
        log_mass: in the grapple [N] kg.
    """
    swing, boom, pitch = angles[:, 0], angles[:, 1], angles[:, 1] + angles[:, 2]
    elbow = m.base_offset + m.boom_length * np.cos(boom)
    parts = (
        (m.base_mass, np.full(len(angles), m.base_x)),
        (m.boom_mass, m.base_offset + m.boom_x * np.cos(boom) - m.boom_y * np.sin(boom)),
        (m.stick_mass, elbow + m.stick_x * np.cos(pitch) - m.stick_y * np.sin(pitch)),
        (m.head_mass + log_mass, elbow + m.stick_length * np.cos(pitch)),
    )
    side = np.abs(np.sin(swing))
    away = np.array([mass * (r * side - site.half_track) for mass, r in parts])
    holding = site.chassis * site.half_track - np.minimum(0.0, away).sum(axis=0)
    result: Floats = (holding - np.maximum(0.0, away).sum(axis=0)) / holding
    return result
