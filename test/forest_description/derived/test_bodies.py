"""Claims about rigid bodies put together: mass, centre and inertia as of the single parts."""

import dataclasses

import numpy as np
import pytest

from forest_description.derived.bodies import (
    PlanarBody,
    boom_body,
    combined,
    hanging_body,
    point_mass,
    stick_body,
    with_log,
)
from forest_description.machine import load_machine
from forest_description.mechanics.load import Log, Pendulum, RotatorAndGrapple

C180, THESIS = load_machine("c180_hoses").manipulator, load_machine("c180_thesis").manipulator
STICK = PlanarBody(7.0, 1.5, 0.2, 3.0, 5.0, 6.0, -0.7)


def about_origin(body):
    """Return the inertia tensor about the frame's origin."""
    x, y, m = body.x, body.y, body.mass
    off = -body.xy - m * x * y
    xx, yy, zz = body.xx + m * y**2, body.yy + m * x**2, body.zz + m * (x**2 + y**2)
    return np.array([[xx, off, 0.0], [off, yy, 0.0], [0.0, 0.0, zz]])


def test_inertias_about_one_point_add_up():
    other = PlanarBody(2.0, -0.5, 0.8, 1.0, 2.0, 2.5, 0.3)
    expected = about_origin(STICK) + about_origin(other)
    np.testing.assert_allclose(about_origin(combined(STICK, other)), expected, rtol=1e-13)


def test_points_make_the_inertia_of_their_second_moments():
    rng = np.random.default_rng(1)
    masses, places = rng.uniform(0.1, 3.0, 20), rng.normal(0.0, 1.0, (20, 2))
    points = [point_mass(m, x, y) for m, (x, y) in zip(masses.tolist(), places.tolist(), strict=True)]
    whole = points[0]
    for point in points[1:]:
        whole = combined(whole, point)
    centre = masses @ places / masses.sum()
    (xx, xy), (_, yy) = np.cov(places.T, aweights=masses, ddof=0) * masses.sum()
    assert whole == pytest.approx((masses.sum(), *centre, yy, xx, xx + yy, xy))


def test_order_does_not_matter_and_nothing_adds_nothing():
    parts = [point_mass(3.0, 1.0, -0.5), point_mass(5.0, -0.2, 0.4), STICK]
    forward = combined(combined(parts[0], parts[1]), parts[2])
    assert combined(parts[2], combined(parts[1], parts[0])) == pytest.approx(forward)
    nothing = point_mass(0.0, 1.0, 0.0)
    assert combined(STICK, nothing) == pytest.approx(STICK)
    assert combined(nothing, nothing) == nothing


@pytest.mark.parametrize("body", [boom_body, stick_body])
def test_a_c180_link_is_possible_and_the_thesis_link_is_not(body):
    """No moment of inertia is more than the other two together, as for any distribution of mass."""

    def excess(m):
        bare = body(dataclasses.replace(m, head_mass=0.0))
        moments = (bare.xx, bare.yy, bare.zz)
        return 2.0 * max(moments) - sum(moments)

    assert excess(C180) == pytest.approx(0.0, abs=1e-9)
    assert excess(THESIS) > 70.0


def test_thesis_folding_leaves_out_the_heads_share_of_xx_and_xy_only():
    assert (stick_body(THESIS).xx, stick_body(THESIS).xy) == (0.0, 0.0)
    full, thesis = (stick_body(dataclasses.replace(C180, head_folding=how)) for how in ("full", "thesis"))
    assert thesis == full._replace(xx=C180.stick_xx, xy=C180.stick_xy)
    head = point_mass(C180.head_mass, C180.stick_length, 0.0)
    bare = stick_body(dataclasses.replace(C180, head_mass=0.0))
    np.testing.assert_allclose(about_origin(full), about_origin(bare) + about_origin(head), rtol=1e-12)


@pytest.mark.parametrize("how", ["full", "thesis"])
def test_a_log_is_folded_fully_whatever_the_head_is(how):
    log = Log(mass=900.0, x=0.4, y=-0.3)
    empty = dataclasses.replace(C180, head_folding=how)
    point = point_mass(log.mass, C180.stick_length + log.x, log.y)
    expected = about_origin(stick_body(empty)) + about_origin(point)
    loaded = stick_body(dataclasses.replace(empty, log=log))
    np.testing.assert_allclose(about_origin(loaded), expected, rtol=1e-12)


def test_head_and_log_weigh_in_the_stick_or_hang_never_both():
    log, pendulum = Log(500.0, 1.5, 0.0), Pendulum(0.9, 60.0, 250.0)
    assert hanging_body(C180) is None
    swinging = dataclasses.replace(C180, log=log, pendulum=pendulum)
    assert stick_body(swinging).mass == C180.stick_mass
    hanging = hanging_body(swinging)
    assert hanging.mass == C180.head_mass + log.mass
    assert hanging.mass * hanging.length == pytest.approx(C180.head_mass * 0.9 + log.mass * log.x)
    about_joint = 60.0 + C180.head_mass * 0.9**2 + log.mass * log.x**2
    assert hanging.inertia + hanging.mass * hanging.length**2 == pytest.approx(about_joint)


PARTS = RotatorAndGrapple(
    rotator_mass=100.0,
    rotator_centre=0.2,
    rotator_length=0.5,
    grapple_centre=0.6,
    grapple_inertia=80.0,
    grip=0.9,
    damping=300.0,
)
HANGING = dataclasses.replace(C180, pendulum=PARTS)


def test_rotator_and_grapple_are_one_head_of_both_their_masses():
    head, grapple = hanging_body(HANGING), C180.head_mass - 100.0
    assert head.mass == C180.head_mass
    assert head.mass * head.length == pytest.approx(100.0 * 0.2 + grapple * 1.1)
    about_joint = 100.0 * 0.2**2 + 80.0 + grapple * 1.1**2
    assert head.inertia + head.mass * head.length**2 == pytest.approx(about_joint)


@pytest.mark.parametrize(
    ("crane", "place"),
    [
        (C180, (0.0, 0.0)),
        (dataclasses.replace(C180, pendulum=Pendulum(0.9, 60.0, 250.0)), (0.9, 0.0)),
        (HANGING, (1.4, 0.0)),
        (dataclasses.replace(C180, log=Log(1.0, 0.3, -0.2)), (0.3, -0.2)),
    ],
    ids=["fixed head", "hanging head", "grapple", "log of its own"],
)
def test_a_log_is_held_where_the_head_grips(crane, place):
    holding = with_log(crane, 450.0, 4.0)
    assert holding.log == Log(450.0, *place, 4.0)
    assert holding.log.inertia == pytest.approx(450.0 * 4.0**2 / 12.0)
    assert with_log(holding, 0.0, 4.0) == dataclasses.replace(crane, log=None)
