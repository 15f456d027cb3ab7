"""Claims about oil with air as a spring: up to which amplitude it is the one of the linear model."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from forest_description.machine import load_machine
from forest_sim.analysis.oil_softening import WITHIN, amplitudes, heading, stiffness
from forest_sim.cli.main import main
from forest_sim.equations.plant import at_joints, transmissions
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.simulation.open_loop import start_angles
from forest_sim.solver.equilibrium import equilibrium

CASES = [("loader", 2), ("c180", 0), ("c180", 1)]


def at_rest(name):
    """Parameters, resting machine, and every axis' state and actuator."""
    machine = load_machine(name)
    p = plant_parameters(machine)
    point = equilibrium(start_angles(machine), p)
    plant = at_joints(point.plant, p)
    at = transmissions(plant.swing.angle, plant.boom.angle, plant.stick.angle, p)
    return machine, p, point, list(zip(plant.axes, at, p.axes, strict=True))


def room(pressure, oil):
    """What oil and air take at a pressure, over what they take at tank pressure: the law of the docs."""
    air = oil.air
    s = min(1.0, max(0.0, pressure / air.dissolving_pressure))
    above = air.tank_pressure - air.vapour_pressure
    free = (1.0 - s) ** 2 * (1.0 + 2.0 * s) * above / (above + pressure)
    return (1.0 / (1.0 + pressure / oil.bulk_modulus) + air.share * free) / (1.0 + air.share)


def pressure_in(volume, wall, held, oil):
    """Pressure at which a volume with an elastic wall holds so much oil."""
    low = 1.0 + oil.air.vapour_pressure - oil.air.tank_pressure
    return brentq(lambda p: (volume + wall * p) / room(p, oil) - held, low, 2e9, xtol=1e-3)


def rung(name, place, amplitude):
    """Frequency [Hz] of 1 kg (kg m^2) that swings on the axis' shut oil by an amplitude; integrated."""
    machine, _, _, axes = at_rest(name)
    (s, t, axis), oil = axes[place], machine.oil
    sides = []
    for rest, area, v in (
        (s.pressure_1, axis.actuator.displacement_1, axis.oil_1),
        (s.pressure_2, -axis.actuator.displacement_2, axis.oil_2),
    ):
        held = (v.volume + v.area * t.position + v.wall * rest) / room(rest, oil)
        sides.append((rest, area, v, held))

    def force(x):
        total = 0.0
        for rest, area, v, held in sides:
            volume = v.volume + v.area * (t.position + x)
            left = held if v.area else held - area * x
            total += area * (pressure_in(volume, v.wall, left, oil) - rest)
        return total

    def turned(time, y):
        return y[1] if time > 0.0 else -1.0

    turned.terminal, turned.direction = True, 1.0
    longest, start = 2.0 * math.pi * math.sqrt(1e-7 / -force(1e-7)), amplitude
    for _ in range(6):  # one side may be softer: it swings further to that one
        done = solve_ivp(
            lambda _, y: (y[1], force(y[0])), (0.0, longest), (start, 0.0), events=turned,
            rtol=1e-7, atol=(1e-9 * amplitude, 1e-9), max_step=longest / 100.0,
        )  # fmt: skip
        start *= 2.0 * amplitude / (start - done.y_events[0][0][0])
    return 0.5 / done.t_events[0][0]


@pytest.mark.parametrize(("name", "place"), CASES)
def test_at_the_amplitude_that_is_told_a_mass_on_the_oil_rings_a_twentieth_faster_or_slower(name, place):
    _, p, point, axes = at_rest(name)
    amplitude = list(amplitudes(point, p).values())[place]
    kept = stiffness(amplitude, *axes[place]) / stiffness(1e-7, *axes[place])
    assert abs(kept - 1.0) == pytest.approx(WITHIN, abs=0.003)
    assert rung(name, place, amplitude) / rung(name, place, 1e-6) == pytest.approx(math.sqrt(kept), rel=0.02)


def test_below_it_the_spring_is_within_a_tenth():
    _, p, point, axes = at_rest("loader")
    for (state, t, axis), amplitude in zip(axes, amplitudes(point, p).values(), strict=True):
        at_once = stiffness(1e-7, state, t, axis)
        for share in np.linspace(0.05, 0.85, 9):
            assert abs(stiffness(share * amplitude, state, t, axis) / at_once - 1.0) < WITHIN


def test_oil_without_air_has_no_such_end(capsys):
    _, p, point, _ = at_rest("c180_hoses")
    assert amplitudes(point, p) == {}
    assert main(["modes", "--machine", "c180_hoses"]) == 0
    assert "oil with air" not in capsys.readouterr().out


def test_the_command_tells_it_of_a_machine_with_air_behind_shut_valves(capsys):
    assert main(["modes", "--machine", "loader"]) == 0
    assert "oil with air: its springs are within a tenth" in capsys.readouterr().out
    assert main(["modes", "--machine", "loader", "--voltages", "0", "4", "0"]) == 0
    assert "oil with air" not in capsys.readouterr().out
    assert heading({"swing": 1.1e-3, "boom": 3.2e-4}).endswith("up to swing 1.1 mrad, boom 0.32 mm")


@pytest.mark.parametrize("name", ["c180", "loader", "forwarder"])
def test_the_docs_have_the_amplitudes(name):
    _, p, point, _ = at_rest(name)
    page = (Path(__file__).parents[3] / "docs/explanation/equations.md").read_text("utf-8")
    told = "".join(f" {1e3 * amplitude:.2g} |" for amplitude in amplitudes(point, p).values())
    assert f"| `{name}` |{told}" in page
