"""How fast each joint may go where the crane is, by the controller's own law: what its limit `rate` acts on.

The law knows the machine's file and the default rate limits. A weaker valve that the driver has
learnt, a joint that cannot follow, or other rate limits slow a joint below this.
"""

import math
from collections.abc import Mapping

from forest_control.config.controller_settings import Settings
from forest_control.limits.actuator_speed_limits import joint_rate_limits, speed_limit_parameters
from forest_control.valve.tracking_limit import FULL
from forest_control.valve.valve_driver_parameters import axis_drivers
from forest_description.machine import Machine
from forest_description.types import AXES

HIGHEST = Settings._field_defaults["joint_rates"]  # [rad/s]


class GreatestRates:
    """The signals `crane/JOINT.greatest_rate` [rad/s] of swing, boom and stick.

    Args:
        machine: Whose valves open them.
    """

    def __init__(self, machine: Machine) -> None:
        self._parameters = speed_limit_parameters(machine, axis_drivers(machine))

    def signals(self, joints: Mapping[str, float]) -> dict[str, float]:
        """Return the greatest rates in the directions in which the joints move; NaN where unknown.

        Args:
            joints: `AXIS.position` [rad] and `AXIS.velocity` [rad/s]; absent or NaN: unknown.
        """
        q, rates = (
            [joints.get(f"{axis}.{what}", math.nan) for axis in AXES] for what in ("position", "velocity")
        )
        names = [f"crane/{axis}.greatest_rate" for axis in AXES]
        if not all(map(math.isfinite, (*q, *rates))):
            return dict.fromkeys(names, math.nan)
        most = joint_rate_limits((q[0], q[1], q[2]), (rates[0], rates[1], rates[2]), self._parameters, FULL)
        return dict(zip(names, map(min, most, HIGHEST), strict=True))
