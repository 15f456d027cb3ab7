"""What moves a pump: its swash plate, which takes time, and an engine, whose speed droops.

| symbol | name | unit |
|---|---|---|
| s | displacement over the greatest one, 0..1 | 1 |
| s_d | that which compensator and torque limiter ask for | 1 |
| T_up, T_down | time constants of the swash plate | s |
| n, n_0 | speed; speed without load | rad/s |
| T | torque of the engine | N m |
| T_max, W | its greatest torque and power | N m, W |
| k | governor, T_max over the droop of speed | N m s |
| T_p | torque of the pumps | N m |
| J | inertia of engine and pumps | kg m^2 |

    ds/dt = (s_d - s)/T_up or T_down,    J dn/dt = T - T_p
    T = max(0, min(k (n_0 - n), T_max, W/n))

A first-order lag, slower up than down, is Hopsan's load-sensing pump. A proportional governor is
what speed droop is named after.

An engine that falls to its stall speed gives no torque from there on. The pumps stop it, and it
stays at rest: nobody starts it again. At rest it delivers nothing.
"""

import math
from typing import NamedTuple

from forest_description.hydraulics.pump import LoadSensingPump, PressureCompensatedPump, Pump


class PumpDrive(NamedTuple):
    """Constants of swash plate and engine."""

    present: int  # 0: neither is modelled
    up: float  # 1/T_up [1/s]; 0: the plate is at once where it is asked to be
    down: float  # 1/T_down [1/s]
    inertia: float  # J [kg m^2]; 0: the speed is constant
    speed: float  # n_0 [rad/s]
    governor: float  # k [N m s]
    torque: float  # T_max [N m]
    power: float  # W [W]
    stall: float  # [rad/s]


class PumpState(NamedTuple):
    """Swash plate and engine; also holds their time derivatives. Zeros where neither is modelled."""

    stroke: float = 0.0  # s
    speed: float = 0.0  # n [rad/s]


class Sloped(NamedTuple):
    """A displacement, or the flow of it, and its slopes by pressures."""

    value: float
    slope: float
    control: float = 0.0  # its slope by P_r


NO_DRIVE = PumpDrive(0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
UNDRIVEN = PumpState()


def pump_drive(pump: Pump) -> PumpDrive:
    """Return the kernel's constants of a pump's swash plate and engine."""
    if not isinstance(pump, PressureCompensatedPump | LoadSensingPump):
        return NO_DRIVE
    up, down, engine = pump.stroke_up_time, pump.stroke_down_time, pump.engine
    if up is None and engine is None:
        return NO_DRIVE
    drive = NO_DRIVE._replace(present=1, speed=pump.shaft_speed)
    if up is not None and down is not None:
        drive = drive._replace(up=1.0 / up, down=1.0 / down)
    if engine is not None:
        drive = drive._replace(
            inertia=engine.inertia,
            governor=engine.torque / (engine.droop * pump.shaft_speed),
            torque=engine.torque,
            power=pump.engine_power,
            stall=engine.stall_speed,
        )
    return drive


def stroke_rate(stroke: float, asked: float, d: PumpDrive) -> float:
    """Return ds/dt [1/s] of a swash plate that is asked for s_d; 0 for one without a lag."""
    return (d.up if asked > stroke else d.down) * (asked - stroke)


def stroke_after(stroke: float, asked: Sloped, step: float, d: PumpDrive) -> Sloped:
    """Return s at the end of an implicit stage, s = stroke + step ds/dt, and its slopes."""
    if d.up == 0.0:
        return asked
    ratio = step * (d.up if asked.value > stroke else d.down)
    share = ratio / (1.0 + ratio)
    return Sloped(stroke + share * (asked.value - stroke), share * asked.slope, share * asked.control)


def engine_torque(speed: float, d: PumpDrive) -> float:
    """Return T [N m] at a speed [rad/s]."""
    if speed <= d.stall:
        return 0.0
    return max(0.0, min(d.governor * (d.speed - speed), d.torque, d.power / speed))


def speed_after(speed: float, load: float, step: float, d: PumpDrive) -> float:
    """Return n [rad/s] at the end of an implicit stage, J (n - speed) = step (T(n) - T_p).

    T is a least of curves that fall with n, so n is the least of their solutions. Whether the
    engine has stalled is told by the stage's known speed.

    Args:
        speed: the stage's known part of n [rad/s].
        load: T_p [N m].
        step: the stage's implicit step [s].
        d: the drive; with an inertia of 0 its speed is constant.
    """
    if d.inertia == 0.0:
        return d.speed
    gain = step / d.inertia
    coasting = speed - gain * load
    if speed <= d.stall:
        return max(0.0, coasting)
    governed = (coasting + gain * d.governor * d.speed) / (1.0 + gain * d.governor)
    strongest = coasting + gain * d.torque
    powered = 0.5 * (coasting + math.sqrt(coasting * coasting + 4.0 * gain * d.power))
    return max(0.0, coasting, min(governed, strongest, powered))
