"""Claims about dry friction in linear models: for which amplitudes each of the two ends holds."""

import dataclasses
import json
import math

import numpy as np
import pytest
from free_swings import rates_after
from full_machine import rigid
from scipy.integrate import quad

from forest_description.geometry.linkage import lever_arm
from forest_description.machine import load_machine
from forest_sim.analysis.friction_linearisation import (
    amplitude_limits,
    axes_with_friction,
    drive_limits,
    equivalent_damping,
    without_dry_friction,
)
from forest_sim.analysis.mode_map import map_csv, mode_map
from forest_sim.analysis.modes import modes, slow_modes
from forest_sim.cli.main import main
from forest_sim.equations.multibody import HANGING_STILL, mechanics
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.mechanics.friction import FRICTIONLESS, Friction, friction_force, rubbing
from forest_sim.simulation.open_loop import start_angles

LOADER = load_machine("loader")
P = plant_parameters(LOADER)
POSE = start_angles(LOADER)
SEALS = Friction(400.0, 700.0, 0.02, 0.003)
ARM = lever_arm(POSE[2], P.stick_linkage)
SHUT = (0.0, 0.0, 0.0)


def stick(p):
    return slow_modes(modes(POSE, (0.0, 0.0, 0.0), p))["stick"]


@pytest.mark.parametrize("amplitude", [1e-4, 0.0015, 0.004, 0.03, 0.5])
def test_the_equivalent_damper_takes_as_much_energy_as_the_friction(amplitude):
    speed = lambda t: amplitude * math.sin(t)  # noqa: E731
    taken, _ = quad(lambda t: friction_force(speed(t), SEALS) * speed(t), 0.0, 2.0 * math.pi, limit=200)
    assert equivalent_damping(amplitude, SEALS) * amplitude**2 * math.pi == pytest.approx(taken, rel=1e-3)


def test_the_ends_are_the_slope_at_rest_and_coulombs_describing_function():
    assert equivalent_damping(1e-7, SEALS) == pytest.approx(rubbing(0.0, SEALS).slope, rel=1e-6)
    assert equivalent_damping(5.0, SEALS) == pytest.approx(4.0 * 400.0 / (math.pi * 5.0), rel=1e-3)
    assert equivalent_damping(1.0, FRICTIONLESS) == 0.0


def test_below_the_small_end_the_slope_holds_and_at_the_large_one_viscous_friction_is_as_strong():
    ends = amplitude_limits(SEALS, 5000.0)
    slope = rubbing(0.0, SEALS).slope
    assert 0.89 * slope < equivalent_damping(ends.small, SEALS) < 0.93 * slope
    assert equivalent_damping(2.0 * ends.small, SEALS) < 0.8 * slope
    assert equivalent_damping(ends.large, SEALS) == pytest.approx(5000.0, rel=1e-6)
    assert amplitude_limits(SEALS, 0.0).large == math.inf


def test_only_axes_with_dry_friction_have_ends_each_of_its_own_friction():
    ends = axes_with_friction(P)
    assert list(ends) == ["boom", "stick"]
    assert ends["boom"].small == pytest.approx(0.5 * 0.002)
    assert ends["stick"].small == pytest.approx(0.5 * 0.0025)
    assert equivalent_damping(ends["stick"].large, P.stick.friction) == pytest.approx(7000.0, rel=1e-6)
    assert axes_with_friction(plant_parameters(load_machine("c180_hoses"))) == {}


def test_a_small_kick_of_the_stick_dies_without_an_oscillation_as_the_small_end_says():
    assert stick(P) is None
    kick = 0.2 * axes_with_friction(P)["stick"].small / ARM
    rates = rates_after(LOADER, "stick", kick, 0.1)
    assert rates[0] > 0.1 * kick
    assert np.abs(rates[40:]).max() < 0.15 * kick  # the boom, which does ring, takes the stick along


def rung(machine, kick):
    """Frequency [Hz] of the stick's greatest share above the boom's, after a kick [m/s], and that share."""
    rates = rates_after(machine, "stick", kick / ARM, 0.15)
    shares = np.abs(np.fft.rfft(rates * np.hanning(len(rates)), 1 << 15))
    frequencies = np.fft.rfftfreq(1 << 15, 2.5e-4)
    above_boom = np.where(frequencies > 25.0, shares, 0.0)
    return frequencies[np.argmax(above_boom)], above_boom.max() / shares.max()


def test_a_large_kick_of_the_stick_rings_as_the_large_end_says():
    """Of oil without air: with air it softens, as the kick pulls its pressure to the tank's and below."""
    large = axes_with_friction(P)["stick"].large
    airless = dataclasses.replace(LOADER, oil=dataclasses.replace(LOADER.oil, air=None))
    mode = stick(without_dry_friction(plant_parameters(airless)))
    frequency, share = rung(airless, 3.0 * large)
    assert frequency == pytest.approx(mode.frequency, rel=0.03)
    assert share > 0.5
    assert mode.damping < 0.05
    soft = stick(without_dry_friction(P))
    assert soft.frequency == pytest.approx(35.0, abs=0.1)
    assert rung(LOADER, large)[0] == pytest.approx(33.2, abs=0.1)
    assert rung(LOADER, 3.0 * large)[0] == pytest.approx(28.3, abs=0.1)


def test_the_map_of_a_machine_with_dry_friction_has_both_ends():
    points = mode_map(LOADER, 2.0)
    assert points
    for point in points:
        held, free = point.modes["stick"], point.sliding["stick"]
        assert free.damping < 0.05
        assert held is None or held.damping > 5.0 * free.damping
    header, *rows = map_csv(points).splitlines()
    assert "stick_sliding_frequency[Hz]" in header
    assert float(rows[0].split(",")[header.split(",").index("stick_sliding_damping[1]")]) == pytest.approx(
        points[0].sliding["stick"].damping, rel=1e-5
    )


def test_without_dry_friction_nothing_else_is_left_out():
    free = without_dry_friction(P)
    assert free.stick.friction == FRICTIONLESS
    bare = dataclasses.replace(
        LOADER,
        boom=dataclasses.replace(LOADER.boom, friction=None),
        stick=dataclasses.replace(LOADER.stick, friction=None),
    )
    assert free == plant_parameters(bare)


def test_the_command_tells_both_ends_with_their_amplitudes(capsys):
    assert main(["modes", "--machine", "loader"]) == 0
    small, large = capsys.readouterr().out.split("large oscillations", 1)
    assert "piston speeds below boom 1 mm/s, stick 1.25 mm/s" in small
    assert "piston speeds above boom 99.3 mm/s, stick 100 mm/s" in large
    assert " stick  links on oil" not in small
    assert " stick  links on oil" in large


@pytest.mark.parametrize(
    ("machine", "axes", "more"), [("loader", ["boom", "stick"], 1), ("c180_hoses", [], 0)]
)
def test_json_has_both_ends_with_their_amplitudes(machine, axes, more, capsys):
    assert main(["modes", "--machine", machine, "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert list(told["dry_friction_speeds_m_s"]) == axes
    assert len(told["modes_without_dry_friction"]) == len(told["modes"]) + more


def test_a_swing_that_sticks_has_ends_of_its_own():
    """Small: the bearing's spring alone. Large: as the machine without play and bearing friction."""
    real = rigid(load_machine("c180"))
    real = dataclasses.replace(real, manipulator=dataclasses.replace(real.manipulator, pendulum=None))
    p = plant_parameters(real)
    ends, b = drive_limits(p), real.swing.friction
    assert ends.small == pytest.approx(b.elastic_share * b.coulomb_torque / b.stiffness)
    r = 0.5 * real.swing.backlash.free_way / ends.large
    assert 2.0 / math.pi * (math.asin(r) + r * math.sqrt(1.0 - r * r)) == pytest.approx(0.1, rel=0.01)
    time = (np.arange(4000) + 0.5) * 2.0 * math.pi / 4000
    speeds = ends.fast * np.sin(time)
    friction = np.sign(speeds) * (800.0 + 300.0 / (1.0 + (speeds / b.stribeck_speed) ** 2))
    taken = float(np.mean(friction * np.sin(time))) * 2.0 / ends.fast
    assert taken == pytest.approx(real.swing.damping, rel=1e-3)
    pose = (0.0, 0.4, -1.4)
    small, large = (slow_modes(modes(pose, SHUT, q))["swing"] for q in (p, without_dry_friction(p)))
    inertia = mechanics(pose, SHUT, HANGING_STILL, p).inertia.m_11
    assert 2.0 * math.pi * small.frequency == pytest.approx(math.sqrt(b.stiffness / inertia), rel=1e-3)
    bare = dataclasses.replace(real.swing, friction=None, backlash=None)
    free = slow_modes(modes(pose, SHUT, plant_parameters(dataclasses.replace(real, swing=bare))))["swing"]
    assert large.frequency == pytest.approx(free.frequency, rel=0.02)
    assert drive_limits(P) is None
