"""What a joystick's axes mean: which lever moves what, and the deadman.

| game_controller axis | tip schemes | joint scheme |
|---|---|---|
| left_x, left positive | tip to the left, +y | swing to the left |
| left_y, up positive | tip away, +x | stick out |
| right_y, up positive | tip up, +z | boom up |

How fast a deflection moves the tip is the operator's profile (`operator_profile`).

The deadman is a button that must be held (left shoulder by default): without it, everything stands
still.
"""

from typing import NamedTuple

from forest_description.types import Vec3

LEFT_X = 0  # [1] index in Joy.axes: order of ROS's game_controller_node
LEFT_Y = 1  # [1] index in Joy.axes: order of ROS's game_controller_node
RIGHT_Y = 3  # [1] index in Joy.axes: order of ROS's game_controller_node
AXIS_COUNT = 6  # [1] axes of a Joy message: those of ROS's game_controller_node
BUTTON_COUNT = 21  # [1] buttons of a Joy message: those of ROS's game_controller_node
LEFT_SHOULDER = 9  # [1] index in Joy.buttons: order of ROS's game_controller_node


class Levers(NamedTuple):
    """Three lever deflections, -1..1, named by the joint that they move in the joint scheme."""

    swing: float
    boom: float
    stick: float


REST = Levers(0.0, 0.0, 0.0)


def levers_from_axes(axes: tuple[float, ...]) -> Levers:
    """Return the levers of a Joy message's axes; deflections beyond 1 count as 1.

    Raises:
        IndexError: fewer than 4 axes; callers check the message first.
    """
    return Levers(*(max(-1.0, min(1.0, axes[i])) for i in (LEFT_X, RIGHT_Y, LEFT_Y)))


def axes_from_levers(levers: Levers) -> tuple[float, ...]:
    """Return a Joy message's axes in game_controller order."""
    axes = [0.0] * AXIS_COUNT
    axes[LEFT_X], axes[RIGHT_Y], axes[LEFT_Y] = levers
    return tuple(axes)


def levers_for_tip_velocity(velocity: Vec3, speed: float) -> Levers:
    """Return the levers that ask for a tip velocity [m/s]; straight stick curves, Cartesian frame."""
    return Levers(velocity[1] / speed, velocity[2] / speed, velocity[0] / speed)


def rate_mode_rates(levers: Levers, rates: Vec3) -> Vec3:
    """Return the joint rates [rad/s] of levers; a full deflection is the joint's entry in `rates`."""
    return levers.swing * rates[0], levers.boom * rates[1], levers.stick * rates[2]
