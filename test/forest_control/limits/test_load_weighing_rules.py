"""The load's weight by the boom's pressures, step by step: friction, pressures that are lost, what limits."""

import dataclasses
import math

import pytest

from forest_control.limits.load_weighing import (
    LOST,
    SETTLED,
    UNKNOWN,
    UNREAD,
    Weighing,
    own_weight,
    weighed,
    weighing_parameters,
)
from forest_control.pipeline.control_state import REST, State, stopped
from forest_description.derived.limits import pose_at
from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD

REAL = load_machine("c180")


def settled(before, q, force, c, rates=ZERO):
    """The weighing after two seconds under a force of the boom's cylinder [N]."""
    for _ in range(round(4.0 * SETTLED / PERIOD)):
        before = weighed(before, q, rates, (force / c.areas[0], 0.0), c, PERIOD)
    return before


def test_what_friction_may_hold_changes_no_mass_at_rest_and_what_is_more_does():
    c, q = weighing_parameters(REAL)._replace(pressure_share=0.0), pose_at((6.0, 0.0, 1.0), REAL)
    per_newton = lever_arm(q[1], c.linkage) / (c.gravity * (6.0 - c.links.base_offset))
    rest = settled(UNKNOWN, q, 2e5, c)
    for side in (-1.0, 1.0):
        assert settled(rest, q, 2e5 + 0.99 * side * c.breakaway, c).mass == pytest.approx(rest.mass, abs=0.1)
        more = settled(rest, q, 2e5 + 3.0 * side * c.breakaway, c)
        expected = 2.0 * side * c.breakaway * per_newton
        assert more.mass - rest.mass == pytest.approx(expected, rel=0.05)


def test_a_cylinder_that_slides_has_its_friction_against_the_motion():
    c, q = weighing_parameters(REAL)._replace(pressure_share=0.0, damping=0.0), pose_at((6.0, 0.0, 1.0), REAL)
    arm = lever_arm(q[1], c.linkage)
    rest = settled(UNKNOWN, q, 2e5, c)
    for side in (-1.0, 1.0):
        moving = settled(rest, q, 2e5 + side * c.friction, c, (0.0, side * 0.02 / arm, 0.0))
        assert moving.mass == pytest.approx(rest.mass, abs=3.0)  # of 21 kg that the friction is


def test_without_pressures_the_mass_is_kept_for_a_while_and_is_not_known_then():
    c, q = weighing_parameters(REAL), pose_at((6.0, 0.0, 1.0), REAL)
    weighing, known = settled(UNKNOWN, q, 3e5, c), 0
    mass = weighing.mass
    for _ in range(round(2.0 * LOST / PERIOD)):
        weighing = weighed(weighing, q, ZERO, UNREAD, c, PERIOD)
        assert weighing.mass == mass or math.isnan(weighing.mass)
        known += not math.isnan(weighing.mass)
    assert known * PERIOD == pytest.approx(LOST, abs=2.0 * PERIOD)


def test_the_mass_that_limits_rises_at_once_falls_slowly_and_goes_soon_with_a_load_that_is_dropped():
    c, q = weighing_parameters(REAL), pose_at((6.0, 0.0, 1.0), REAL)
    weighing, counted = settled(UNKNOWN, q, 3e5, c), []
    for k in range(round(4.0 / PERIOD)):
        force = 3e5 + 3e4 * math.sin(2.0 * math.pi * k * PERIOD)
        weighing = weighed(weighing, q, ZERO, (force / c.areas[0], 0.0), c, PERIOD)
        counted.append(weighing.counted - weighing.mass)
    assert min(counted) == 0.0
    assert max(counted) > 15.0
    heavy = weighing.counted
    for k in range(round(2.5 / PERIOD)):
        weighing = weighed(weighing, q, ZERO, (5e4 / c.areas[0], 0.0), c, PERIOD)
        assert weighing.counted >= weighing.mass
        if k == 20:
            assert weighing.counted > 0.97 * heavy
    assert weighing.counted < 0.9 * heavy


def test_near_the_pivot_nothing_is_weighed_and_what_was_known_stays():
    c = weighing_parameters(REAL)
    weighing = settled(UNKNOWN, pose_at((6.0, 0.0, 1.0), REAL), 3e5, c)
    upright = 0.0, 1.2, -3.0
    assert settled(weighing, upright, 0.0, c).mass == weighing.mass


def test_a_stop_forgets_all_motion_and_no_load():
    known = Weighing(mass=430.0, torque=1e4, age=0.0)
    assert stopped(State((0.1, 0.2, 0.3), True, weighing=known)) == REST._replace(weighing=known)


C = weighing_parameters(REAL)
SMOOTH = C._replace(friction=0.0, breakaway=0.0, pressure_share=0.0, damping=0.0)
Q = (0.1, 0.5, -1.4)
ARM = lever_arm(Q[1], C.linkage)


def places(q):
    """Of the stick's pivot and of the tip, from the boom's pivot [m]: outward, up."""
    pivot = C.links.boom * math.cos(q[1]), C.links.boom * math.sin(q[1])
    along, up = C.links.stick * math.cos(q[1] + q[2]), C.links.stick * math.sin(q[1] + q[2])
    return pivot, (pivot[0] + along, pivot[1] + up)


def turned(moment, angle):
    """A body's mass times its centre [kg m], turned by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return c * moment[0] - s * moment[1], s * moment[0] + c * moment[1]


def height(q):
    """Potential energy of the crane without load [J]."""
    pivot, tip = places(q)
    boom, stick = turned(C.boom_moment, q[1])[1], turned(C.stick_moment, q[1] + q[2])[1]
    return C.gravity * (boom + stick + C.stick_mass * pivot[1] + C.head_mass * tip[1])


def energy(v_2, v_3, carried):
    """Kinetic energy [J] of boom, stick and what its tip carries [kg]."""
    (x, z), (x_t, z_t) = places(Q)
    w, (x_s, z_s) = v_2 + v_3, turned(C.stick_moment, Q[1] + Q[2])
    stick = C.stick_mass * (x * x + z * z) * v_2 * v_2 + C.stick_inertia * w * w
    stick += 2.0 * v_2 * w * (x * x_s + z * z_s)
    tip = (z_t * v_2 + (z_t - z) * v_3) ** 2 + (x_t * v_2 + (x_t - x) * v_3) ** 2
    return 0.5 * (C.boom_inertia * v_2 * v_2 + stick + carried * tip)


def inertia(a_2, a_3, carried):
    """Torque about the boom's pivot [N m] of accelerations: the energy's second derivatives."""
    coupled = energy(1.0, 1.0, carried) - energy(1.0, 0.0, carried) - energy(0.0, 1.0, carried)
    return 2.0 * energy(1.0, 0.0, carried) * a_2 + coupled * a_3


def pressed(torque, c=C, back=3e6):
    """Pressures in the boom's cylinder [Pa] of a torque about its pivot, with some on the rod's side."""
    return (torque / ARM + c.areas[1] * back) / c.areas[0], back


def known(mass, torque, rates=(0.0, 0.0), **more):
    """What is remembered of a crane that goes on as it went, with a torque left by its own weight."""
    return Weighing(mass=mass, counted=mass, rates=rates, torque=torque, age=0.0)._replace(**more)


@pytest.mark.parametrize("q", [Q, (0.0, -0.4, -0.3), (0.0, 1.1, -2.5)])
def test_the_crane_s_own_weight_is_the_slope_of_its_height(q):
    up, down = (q[0], q[1] + 1e-4, q[2]), (q[0], q[1] - 1e-4, q[2])
    assert own_weight(q, C) == pytest.approx((height(up) - height(down)) / 2e-4, rel=1e-6)


@pytest.mark.parametrize(("a_2", "a_3"), [(0.0, 0.0), (0.3, 0.0), (0.0, 0.4), (-0.2, 0.3)])
def test_a_crane_that_speeds_up_is_weighed_as_it_stands(a_2, a_3):
    left = math.exp(-PERIOD / 0.1)  # of the rates before; those after lag by 0.1 s of the acceleration
    v = 0.05, -0.03
    rates = v[0] - 0.1 * a_2 / left, v[1] - 0.1 * a_3 / left
    for mass, moved in ((400.0, 400.0), (math.nan, 0.0)):  # what is not known yet counts as nothing
        torque = inertia(a_2, a_3, C.head_mass + moved) + C.gravity * places(Q)[1][0] * 400.0
        pressures = pressed(own_weight(Q, C) + torque)
        found = weighed(known(mass, torque, rates), Q, (9.0, *v), pressures, SMOOTH, PERIOD)
        assert found.mass == pytest.approx(400.0, rel=1e-9)


def test_torque_and_rates_pass_one_low_pass_and_the_first_sample_is_taken_whole():
    first = weighed(UNKNOWN, Q, (0.0, 0.1, -0.2), pressed(own_weight(Q, C) + 5e3), SMOOTH, PERIOD)
    assert first.torque == pytest.approx(5e3)
    assert first.rates == pytest.approx((0.1, -0.2))
    assert first.mass == first.counted == pytest.approx(5e3 / (C.gravity * places(Q)[1][0]))
    second = weighed(first, Q, (0.0, 0.3, 0.4), pressed(own_weight(Q, C) + 9e3), SMOOTH, PERIOD)
    smoothing = 1.0 - math.exp(-PERIOD / 0.1)
    assert second.torque == pytest.approx(5e3 + smoothing * 4e3)
    assert second.rates == pytest.approx((0.1 + smoothing * 0.2, -0.2 + smoothing * 0.6))


@pytest.mark.parametrize("speed", [0.0, 0.003, -0.003, 0.006, -0.02])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_friction_leaves_an_interval_of_which_the_nearest_mass_is_taken_in_a_second(speed, side):
    lever, torque = C.gravity * places(Q)[1][0], 2e4
    pressures, rates = pressed(own_weight(Q, C) + torque), (speed / ARM, 0.0)
    grown = 1.0 + C.pressure_share * sum(pressures)
    slides = min(1.0, abs(speed) / 0.006)
    middle = torque - ARM * (math.copysign(slides * grown * 2700.0, speed) + C.damping * speed)
    bound = (middle + side * ARM * (1.0 - slides) * grown * 4000.0) / lever
    inside, v = bound - side * 0.1 * (1.0 - slides), (0.0, rates[0], 0.0)
    if slides < 1.0:
        assert weighed(known(inside, torque, rates), Q, v, pressures, C, PERIOD).mass == inside
    beyond = weighed(known(bound + side * 100.0, torque, rates), Q, v, pressures, C, PERIOD).mass
    assert beyond == pytest.approx(bound + side * 100.0 * math.exp(-PERIOD / 1.0))
    new = weighed(known(math.nan, torque, rates), Q, v, pressures, C, PERIOD).mass
    assert new == pytest.approx(middle / lever)


@pytest.mark.parametrize(("back", "counts"), [(0.0, 0.0), (2e6, 2e6), (-2e6, 0.0)])
def test_friction_grows_with_each_chamber_s_pressure_and_does_not_shrink_under_none(back, counts):
    torque = -own_weight(Q, C) - 3e4 - C.areas[1] * back * ARM  # the boom is pulled down, its head side empty
    pressures = pressed(own_weight(Q, C) + torque, back=back)
    assert pressures[0] < 0.0
    breakaway = (1.0 + C.pressure_share * counts) * 4000.0
    lever = C.gravity * places(Q)[1][0]
    bound = (torque + ARM * breakaway) / lever
    found = weighed(known(bound + 100.0, torque), Q, ZERO, pressures, C, PERIOD).mass
    assert found == pytest.approx(bound + 100.0 * math.exp(-PERIOD / 1.0))


def test_the_mass_that_counts_rises_with_what_is_weighed_and_falls_to_it_in_ten_seconds():
    pressures = pressed(own_weight(Q, C) + 2e4)
    mass = weighed(UNKNOWN, Q, ZERO, pressures, SMOOTH, PERIOD).mass
    fallen = weighed(known(mass, 2e4, counted=mass + 100.0), Q, ZERO, pressures, SMOOTH, PERIOD)
    assert fallen.counted == pytest.approx(mass + 100.0 * math.exp(-PERIOD / 10.0))
    assert weighed(known(mass, 2e4, counted=mass - 9.0), Q, ZERO, pressures, SMOOTH, PERIOD).counted == mass


@pytest.mark.parametrize(("reach", "is_weighed"), [(0.99, False), (1.01, True)])
def test_what_hangs_within_a_metre_of_the_pivot_is_not_weighed(reach, is_weighed):
    boom = 1.2
    q = (0.0, boom, math.acos((reach - C.links.boom * math.cos(boom)) / C.links.stick) - boom)
    found = weighed(UNKNOWN, q, ZERO, (9e6, 1e6), C, PERIOD)
    assert math.isnan(found.mass) == math.isnan(found.counted) == (not is_weighed)
    assert found.age == 0.0


def test_pressures_that_are_not_read_are_borne_for_half_a_second():
    weighing = known(400.0, 2e4)
    assert weighed(weighing, Q, ZERO, UNREAD, C, 0.49) == weighing._replace(age=0.49)
    assert weighed(weighing._replace(age=0.2), Q, ZERO, UNREAD, C, 0.1).age == pytest.approx(0.3)
    assert weighed(weighing._replace(age=0.2), Q, ZERO, UNREAD, C, 0.31).age == math.inf


def test_the_parameters_are_those_of_the_machine_s_file():
    m, drive = REAL.manipulator, REAL.boom
    assert (C.gravity, C.links, C.linkage, C.damping) == (m.gravity, m.links, drive.linkage, drive.damping)
    assert C.areas == (drive.head_area, drive.rod_area)
    assert C.boom_moment == pytest.approx((m.boom_mass * m.boom_x, m.boom_mass * m.boom_y))
    assert C.stick_moment == pytest.approx((m.stick_mass * m.stick_x, m.stick_mass * m.stick_y))
    assert (C.stick_mass, C.head_mass, C.empty_head) == (m.stick_mass, m.head_mass, m.head_mass)
    assert C.boom_inertia == pytest.approx(m.boom_zz + m.boom_mass * (m.boom_x**2 + m.boom_y**2))
    assert C.stick_inertia == pytest.approx(m.stick_zz + m.stick_mass * (m.stick_x**2 + m.stick_y**2))
    friction = drive.friction
    assert (C.friction, C.breakaway) == (friction.coulomb_force, friction.breakaway_force)
    assert C.pressure_share == pytest.approx(friction.pressure_coefficient / friction.coulomb_force)


def test_a_head_that_is_part_of_the_stick_hangs_from_nothing():
    machine = load_machine("c180_hoses")
    found, m = weighing_parameters(machine), machine.manipulator
    assert (found.head_mass, found.empty_head) == (0.0, m.head_mass)
    assert found.stick_mass == m.stick_mass + m.head_mass
    assert (found.friction, found.breakaway, found.pressure_share) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(("coulomb", "pressed"), [(0.0, None), (2700.0, None), (0.5, 1e-6)])
def test_friction_grows_with_pressure_by_its_share_of_the_seals(coulomb, pressed):
    friction = dataclasses.replace(REAL.boom.friction, coulomb_force=coulomb, pressure_coefficient=pressed)
    machine = dataclasses.replace(REAL, boom=dataclasses.replace(REAL.boom, friction=friction))
    assert weighing_parameters(machine).pressure_share == ((pressed / coulomb) if pressed else 0.0)
