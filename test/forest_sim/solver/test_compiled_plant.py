"""Claims about a machine that stays flat between calls: it is the same machine."""

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_compile import flat_layout
from forest_description.machine import load_machine
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver import compiled_plant
from forest_sim.solver.compiled_plant import FlatPlant, compiled_advance, fastest_run
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.oil_temperature import parameters_at
from forest_sim.solver.state_recording import STATE
from forest_sim.solver.step_schedule import even

P = plant_parameters(load_machine("c180_hoses"))
REST = equilibrium((0.0, 0.5, -1.5), P)
VOLTAGES = ((3.0, 2.5, -2.5), (0.0, 3.0, 1.0), (-4.0, 0.0, 5.0))


def test_a_flat_plant_moves_as_advance_does_to_the_last_bit():
    plant, now = FlatPlant(), REST
    plant.lay_out(REST)
    plant.set_parameters(P)
    for volts in VOLTAGES:
        plant.advance(volts, 1e-3, 40)
        now = compiled_advance()(now, volts, 1e-3, 40, P)
        assert plant.simulation == now
        assert plant.state[STATE.index("boom_angle")] == now.plant.boom.angle
    plant.lay_out(REST)
    assert plant.simulation == REST


def test_machines_that_take_turns_do_not_mix():
    """`advance` remembers what lies flat; it must notice that another machine does."""
    alone, turns = [], [REST, REST]
    for volts in VOLTAGES[:2]:
        now = REST
        for _ in range(3):
            now = compiled_advance()(now, volts, 1e-3, 5, P)
        alone.append(now)
    for _ in range(3):
        turns = [
            compiled_advance()(now, volts, 1e-3, 5, P) for now, volts in zip(turns, VOLTAGES, strict=False)
        ]
    assert turns == alone


def test_a_run_goes_on_with_other_oil_as_the_interpreted_one_does_to_the_last_bit(monkeypatch):
    pack, machine = flat_layout.packer(P), load_machine("c180_hoses")
    oils = [np.array(pack(parameters_at(machine, t)), dtype=np.float64) for t in (300.0, 330.0)]
    compiled, interpreted = np.zeros((2, 2, 6, len(STATE)))

    def filled(rows):
        run = fastest_run(REST)
        for volts, oil, states in zip(VOLTAGES, oils, rows, strict=False):
            run(np.tile(volts, (12, 1)), even(1e-3, 6, 2), oil, states)

    filled(compiled)
    monkeypatch.setattr(compiled_plant, "can_compile", lambda: False)
    filled(interpreted)
    np.testing.assert_array_equal(compiled, interpreted)
    assert np.ptp(compiled[:, :, STATE.index("boom_angle")]) > 0.0
