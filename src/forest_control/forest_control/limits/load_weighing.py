"""Load weighing: the mass that hangs under the tip, from the pressures of the boom's cylinder.

The torque of that cylinder about the boom's pivot carries the crane and the load, and moves both. The stick's
cylinder works between boom and stick: about the boom's pivot it has no part. What the crane's own weight and
inertia leave of the torque, divided by the load's lever, is the load's mass.

| symbol | name | unit |
|---|---|---|
| P_1, P_2 | pressures in the boom's cylinder, head and rod side | Pa |
| tau | torque of its force A_1 P_1 - A_2 P_2 about the boom's pivot | N m |
| q, v, a | joint angles, measured rates, accelerations | rad, rad/s, rad/s^2 |
| G, M | torque of the crane's own weight about that pivot; its row of the mass matrix | N m, kg m^2 |
| x, z | of the tip, from the boom's pivot: outward, up | m |
| m | mass of the load | kg |
| F | friction of the cylinder's seals, by the machine's file | N |
| T_1, T_2 | time constants: of torque and rates; of the mass | s |
| m_c, T_3 | mass that limits count with; time constant with which it falls to m | kg, s |

    m g x = tau - G - M a - m (x z'' - z x'') - friction

A cylinder that moves has its friction F against the motion, and the file tells how much. One that stands may
have any between -F and F. So the pressures tell an interval; the mass that was known is kept as far as it
lies in that. Torque and rates pass the same low-pass of T_1, so that a = (v - v') / T_1 belongs to tau; then
the mass passes one of T_2.

A crane that rocks is weighed now heavier, now lighter. A limit that followed would let the crane go and
hold it by turns, and so feed the rocking. m_c rises with m at once and falls slowly: what is held stays so.

Left out: the platform's tilt, the swing's centrifugal force, a head that sways.
"""

import math
from typing import NamedTuple

from forest_description.derived.bodies import boom_body, stick_body, with_log
from forest_description.geometry.kinematics import Links
from forest_description.geometry.linkage import Linkage, lever_arm
from forest_description.machine import Machine
from forest_description.types import Vec3

Pressures = tuple[float, float]

AVERAGED = 0.1  # [s] T_1: over the first mode of boom and hoses, 8 Hz
SETTLED = 1.0  # [s] T_2: over the rocking of a boom under a load, 2 Hz, and half a sway of its head; chosen
RELEASED = 10.0  # [s] T_3: over several periods of a heavy load's rocking, 1 s; no other was tried
SLIDES = 0.006  # [m/s] of a cylinder from which its friction is known: over the noise of its speed; chosen
LEAST_LEVER = 1.0  # [m] x under which nothing is weighed: there a load hardly turns the boom
UNREAD: Pressures = (math.nan, math.nan)  # [Pa] where nobody measures them
LOST = 0.5  # [s] without pressures after which a load that was weighed is not known any more; chosen


class WeighingParameters(NamedTuple):
    """The crane without load, as the weighing needs it."""

    gravity: float  # g [m/s^2]
    links: Links
    linkage: Linkage  # of the boom
    areas: tuple[float, float]  # A_1, A_2 [m^2]
    boom_moment: tuple[float, float]  # m (x, y) of the boom's centre of mass [kg m]
    stick_moment: tuple[float, float]  # alike, with a head that is part of it
    stick_mass: float  # [kg]
    head_mass: float  # [kg] that hangs from the tip
    empty_head: float  # [kg] of the head without a log, whether it hangs or is part of the stick
    boom_inertia: float  # about the boom's pivot [kg m^2]
    stick_inertia: float  # about the stick's pivot [kg m^2]
    friction: float  # F of a cylinder that slides [N]
    breakaway: float  # F of one that stands [N]
    pressure_share: float  # growth of both per pressure of both chambers [1/Pa]
    damping: float  # viscous friction [N s/m]


class Weighing(NamedTuple):
    """What is remembered between steps."""

    mass: float = math.nan  # m [kg]
    counted: float = math.nan  # m_c [kg]
    rates: tuple[float, float] = (0.0, 0.0)  # of boom and stick, low-passed [rad/s]
    torque: float = math.nan  # tau - G, low-passed [N m]
    age: float = math.inf  # of the newest pressures [s]


UNKNOWN = Weighing()


def weighed(
    before: Weighing, q: Vec3, v: Vec3, pressures: Pressures, c: WeighingParameters, dt: float
) -> Weighing:
    """Return the weighing after dt [s].

    Args:
        before: as it was.
        q: joint angles [rad].
        v: measured joint rates [rad/s].
        pressures: P_1, P_2 [Pa]; NaN where they are not measured.
        c: the crane without load.
        dt: [s].
    """
    force = c.areas[0] * pressures[0] - c.areas[1] * pressures[1]
    if not math.isfinite(force):
        return before._replace(age=before.age + dt) if before.age + dt <= LOST else UNKNOWN
    smoothing, arm = 1.0 - math.exp(-dt / AVERAGED), lever_arm(q[1], c.linkage)
    new, static = math.isnan(before.torque), arm * force - own_weight(q, c)
    kept = static if new else before.torque
    v_2, v_3 = (v[1], v[2]) if new else before.rates
    rates = v_2 + smoothing * (v[1] - v_2), v_3 + smoothing * (v[2] - v_3)
    torque = kept + smoothing * (static - kept)
    a_2, a_3 = (v[1] - rates[0]) / AVERAGED, (v[2] - rates[1]) / AVERAGED
    mass, x = before.mass, _tip(q, c)[0]
    if x >= LEAST_LEVER:
        carried = c.head_mass + (0.0 if math.isnan(mass) else mass)
        left = torque - _inertia(q, a_2, a_3, carried, c)
        mass = _updated(mass, left / (c.gravity * x), arm, arm * rates[0], pressures, c.gravity * x, c, dt)
    counted = _counted(before.counted, mass, dt)
    return Weighing(mass=mass, counted=counted, rates=rates, torque=torque, age=0.0)


def _counted(before: float, mass: float, dt: float) -> float:
    """Return m_c [kg] after dt [s] at a mass."""
    if math.isnan(before) or mass >= before:
        return mass
    return mass + math.exp(-dt / RELEASED) * (before - mass)


def _updated(
    mass: float,
    seen: float,
    arm: float,
    speed: float,
    pressures: Pressures,
    lever: float,
    c: WeighingParameters,
    dt: float,
) -> float:
    """Return the mass [kg] as a torque corrects it.

    Args:
        mass: before.
        seen: what the torque alone would say, friction and all [kg].
        arm: of the cylinder [m].
        speed: of the cylinder [m/s].
        pressures: in it [Pa].
        lever: g x [m^2/s^2].
        c: the crane.
        dt: [s].
    """
    slides = min(1.0, abs(speed) / SLIDES)
    grown = 1.0 + c.pressure_share * (max(0.0, pressures[0]) + max(0.0, pressures[1]))
    known = math.copysign(slides * grown * c.friction, speed) + c.damping * speed
    open_to = (1.0 - slides) * grown * c.breakaway
    low, high = seen - arm * (known + open_to) / lever, seen - arm * (known - open_to) / lever
    if math.isnan(mass):
        return 0.5 * (low + high)
    within = max(low, min(high, mass))
    return mass + (1.0 - math.exp(-dt / SETTLED)) * (within - mass)


def own_weight(q: Vec3, c: WeighingParameters) -> float:
    """Return G [N m]: what holds the crane without load about the boom's pivot. Thesis eq. 3.15."""
    c_2, s_2 = math.cos(q[1]), math.sin(q[1])
    c_23, s_23 = math.cos(q[1] + q[2]), math.sin(q[1] + q[2])
    boom = c.boom_moment[0] * c_2 - c.boom_moment[1] * s_2
    stick = c.stick_moment[0] * c_23 - c.stick_moment[1] * s_23 + c.stick_mass * c.links.boom * c_2
    return c.gravity * (boom + stick + c.head_mass * _tip(q, c)[0])


def _inertia(q: Vec3, a_2: float, a_3: float, carried: float, c: WeighingParameters) -> float:
    """Return M a [N m] of the crane and of what its tip carries [kg]. Thesis eq. 3.15."""
    coupling = c.links.boom * (c.stick_moment[0] * math.cos(q[2]) - c.stick_moment[1] * math.sin(q[2]))
    boom = c.boom_inertia + c.stick_mass * c.links.boom * c.links.boom + c.stick_inertia + 2.0 * coupling
    x, z = _tip(q, c)
    x_3, z_3 = c.links.stick * math.cos(q[1] + q[2]), c.links.stick * math.sin(q[1] + q[2])
    of_tip = x * (x * a_2 + x_3 * a_3) + z * (z * a_2 + z_3 * a_3)
    return boom * a_2 + (c.stick_inertia + coupling) * a_3 + carried * of_tip


def _tip(q: Vec3, c: WeighingParameters) -> tuple[float, float]:
    """Return x, z [m]."""
    x = c.links.boom * math.cos(q[1]) + c.links.stick * math.cos(q[1] + q[2])
    return x, c.links.boom * math.sin(q[1]) + c.links.stick * math.sin(q[1] + q[2])


def weighing_parameters(machine: Machine) -> WeighingParameters:
    """Return the crane of a machine's file without the log that its head may hold."""
    m, drive = with_log(machine.manipulator, 0.0, 0.0), machine.boom
    boom, stick = boom_body(m), stick_body(m)
    friction = drive.friction
    coulomb = 0.0 if friction is None else friction.coulomb_force
    pressed = 0.0 if friction is None else friction.pressure_coefficient or 0.0
    return WeighingParameters(
        gravity=m.gravity,
        links=m.links,
        linkage=drive.linkage,
        areas=(drive.head_area, drive.rod_area),
        boom_moment=(boom.mass * boom.x, boom.mass * boom.y),
        stick_moment=(stick.mass * stick.x, stick.mass * stick.y),
        stick_mass=stick.mass,
        head_mass=0.0 if m.pendulum is None else m.head_mass,
        empty_head=m.head_mass,
        boom_inertia=boom.zz + boom.mass * (boom.x**2 + boom.y**2),
        stick_inertia=stick.zz + stick.mass * (stick.x**2 + stick.y**2),
        friction=coulomb,
        breakaway=0.0 if friction is None else friction.breakaway_force,
        pressure_share=pressed / coulomb if coulomb > 0.0 else 0.0,
        damping=drive.damping,
    )
