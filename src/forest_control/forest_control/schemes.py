"""The control schemes of Thesis fig. 5.2, each one line of the block diagram.

| symbol | name | unit |
|---|---|---|
| a | governed joint rates: J^-1 x'_des, or the levers' own in joint mode | rad/s |
| s, v | measured joint angle, rate | rad, rad/s |
| r | reference angle, the integral of a | rad |
| u | commanded joint rate, to the valve driver | rad/s |
| K* | pre-loop gain, 1 / (closed-loop gain at rest) | |
| K_v | velocity servo gain | |
| K_p, K_d | position servo gains | 1/s, 1 |
| b | rate of change of a | rad/s^2 |
| T | lead: what spool, hoses and sampling lag behind the command | s |
| w | integral of K_i (r - s) | rad/s |

The thesis writes its servos around a plant v' = -w_n v + k u; here the driver makes the plant's gain one (u
is a rate, and the machine settles at it), so the servos' W_0/k is one and K* = (1 + K_v)/K_v.
"""

from enum import Enum
from typing import NamedTuple

Triple = tuple[float, float, float]


class Scheme(str, Enum):
    """How a wish becomes joint rates."""

    JOINT = "joint"
    JACOBIAN_VELOCITY = "jacobian_velocity"
    JACOBIAN_POSITION = "jacobian_position"
    COORDINATED = "coordinated"


class Gains(NamedTuple):
    """Servo gains per joint, swing, boom, stick."""

    velocity: Triple  # K_v
    position: Triple  # K_p [1/s]
    damping: Triple  # K_d


def joint(a: float) -> float:
    """Conventional control: each lever commands its joint's rate, open loop. Thesis section 5.1."""
    return a


def jacobian_velocity(a: float, v: float, k_v: float) -> float:
    """Scheme (c), inverse Jacobian, velocity servo: u = K_v (K* a - v).

    Thesis section 5.2, fig. 5.2, 5.3.
    """
    pre_loop_gain = (1.0 + k_v) / k_v
    return k_v * (pre_loop_gain * a - v)


def jacobian_position(r: float, s: float, v: float, k_p: float, k_d: float) -> float:
    """Scheme (d), inverse Jacobian, position servo: u = K_p (r - s) - K_d v.

    Thesis section 5.2, fig. 5.2, 5.3.
    """
    return k_p * (r - s) - k_d * v


def coordinated(a: float, b: float, r: float, s: float, w: float, lead: float, k_p: float) -> float:
    """Reference velocity with lead, closed on the tip's position: u = a + T b + K_p (r - s) + w.

    The wish passes straight through, earlier by the lead; the error only carries what valve and model are
    wrong by. r is the pose that holds the tip on its path, so an error of the tip is one of the joints.
    """
    return a + lead * b + k_p * (r - s) + w
