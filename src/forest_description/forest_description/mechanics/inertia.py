"""Which moments of inertia a rigid body can have.

| symbol | name | unit |
|---|---|---|
| I_xx, I_yy, I_zz | moments about the centre of mass | kg m^2 |
| I_xy | product about it, the integral of x y dm; the body is symmetric about the plane of x and y | kg m^2 |
| S_xx, S_yy | integrals of x^2 dm, y^2 dm: (I_yy + I_zz - I_xx)/2, (I_xx + I_zz - I_yy)/2 | kg m^2 |

A mass distribution has S_xx, S_yy, S_zz >= 0 (no moment is above the other two together) and I_xy^2
<= S_xx S_yy. A plane body, of no width across the crane's plane, has S_zz = 0, which is I_zz = I_xx
+ I_yy.
"""

import math

from forest_description.config.parameter import MachineError
from forest_description.types import Vec3

ROUNDING = 1e-6  # of the greatest moment, for numbers as they are printed


def require_rigid(link: str, mass: float, moments: Vec3, product: float, unknown_xx: bool = False) -> None:
    """Raise unless a rigid body can have such moments of inertia.

    Args:
        link: "boom" or "stick", as its keys begin.
        mass: [kg].
        moments: I_xx, I_yy, I_zz [kg m^2].
        product: I_xy [kg m^2].
        unknown_xx: whether an I_xx of 0 means that it is unknown, as in Thesis App. B.

    Raises:
        MachineError: it cannot; the message names the keys and what is allowed.
    """
    xx, yy, zz = moments
    slack = ROUNDING * max(moments)
    if mass == 0.0 and (slack > 0.0 or product != 0.0):
        raise MachineError(f"{link}_mass is 0 kg: a body without mass has no inertia; allowed: above 0 kg")
    if xx == 0.0 and unknown_xx:
        xx = max(0.0, zz - yy)
    moments_by_name = {f"{link}_xx": xx, f"{link}_yy": yy, f"{link}_zz": zz}
    for name, value in moments_by_name.items():
        others = [other for other in moments_by_name if other != name]
        most = sum(moments_by_name[other] for other in others)
        if value > most + slack:
            least = value - most + min(moments_by_name[other] for other in others)
            smaller = min(others, key=lambda other: moments_by_name[other])
            raise MachineError(
                f"{name} ({value:.7g} kg*m2) must not be above {' + '.join(others)} ({most:.7g} kg*m2): no "
                f"rigid body has such moments of inertia; allowed: {smaller} of {least:.7g} kg*m2 or more"
            )
    bound = math.sqrt(max(0.0, 0.25 * (yy + zz - xx) * (xx + zz - yy)))
    if abs(product) > bound + slack:
        raise MachineError(
            f"{link}_xy ({product:.7g} kg*m2) is more than a rigid body can have with such {link}_xx, "
            f"{link}_yy and {link}_zz; allowed: {-bound:.7g} .. {bound:.7g} kg*m2"
        )
