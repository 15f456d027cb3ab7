"""Control laws that the matrix compares, each with the valve driver that goes with it.

| name | is |
|---|---|
| coordinated | ours |
| flow_pi | practice: flow fed forward through the valve's static map, PI on each joint's position |
| joint_velocity | rates J^-1 x' of the measured pose, open loop to the valves, as MoveIt Servo sends |
| jacobian_velocity, jacobian_position | the thesis' (c) and (d), see `schemes` |

All know the valves' overlaps and gains, else none would move the crane slowly. `flow_pi` has the gains of the
same rule as ours, and keeps our feed-forward of the oil's compression, which flatters it.
"""

from typing import NamedTuple

from forest_control.config.controller_settings import Settings as ControlSettings
from forest_control.servo.schemes import Scheme
from forest_control.valve.valve_driver_parameters import Settings as DriveSettings
from forest_description.types import ZERO

OPEN_LOOP = 0.01, 0.01, 0.01  # K_v, the least that is allowed: a hundredth of the rate comes back


class Rival(NamedTuple):
    """A control law."""

    control: ControlSettings
    drive: DriveSettings = DriveSettings()


STATIC = DriveSettings(beyond_valve=False, dither_amplitude=0.0)
OURS = Rival(ControlSettings(scheme=Scheme.COORDINATED))
RIVALS = {
    "coordinated": OURS,
    "flow_pi": Rival(ControlSettings(scheme=Scheme.COORDINATED, lead_time=ZERO, rate_gain=ZERO), STATIC),
    "joint_velocity": Rival(
        ControlSettings(scheme=Scheme.JACOBIAN_VELOCITY, velocity_gain=OPEN_LOOP), STATIC
    ),
    "jacobian_velocity": Rival(ControlSettings(scheme=Scheme.JACOBIAN_VELOCITY)),
    "jacobian_position": Rival(ControlSettings(scheme=Scheme.JACOBIAN_POSITION)),
}
