"""Claims about the sign of every flow, pressure drop and motion at every port, both ways."""

import pytest

from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_sim.equations.plant import axis_draw
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.equations.valve_ports import ports_at
from forest_sim.sensors.sensor_readings import at_rest, measure
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium
from forest_sim.solver.power_flows import power_flows

MACHINES = [load_machine(name) for name in ("c180_thesis", "c180_hoses", "loader")]
VOLTS = 5.0


@pytest.fixture(params=MACHINES, ids=lambda machine: machine.name)
def machine(request):
    return request.param


@pytest.mark.parametrize("direction", [1.0, -1.0], ids=["positive", "negative"])
@pytest.mark.parametrize("axis", range(3), ids=AXES)
def test_oil_goes_round_and_the_joint_turns_as_the_voltage_says(machine, axis, direction):
    p = plant_parameters(machine)
    voltages = tuple(direction * VOLTS if i == axis else 0.0 for i in range(3))
    start = (0.0, 0.5, -1.5)
    now = compiled_advance()(equilibrium(start, p), voltages, 1e-3, 700, p)
    state, ports = now.plant[axis], ports_at(now.spools, p)[axis]
    assert direction * state.rate > 0.01
    assert direction * (state.angle - start[axis]) > 0.001
    # Hose 1 counts from the valve, hose 2 to the valve: in positive motion oil goes out by 1, home by 2.
    assert direction * state.flow_1 > 0.0
    assert direction * state.flow_2 > 0.0
    # Whichever port it is, the axis takes from the supply what goes out.
    draw = axis_draw(state, ports, now.plant.supply.pressure).flow
    assert draw == pytest.approx(state.flow_1 if direction > 0 else -state.flow_2, rel=0.05)
    seen = measure(now, at_rest(now, p), p, 5e-3)[1]
    valve_1, actuator_1, valve_2, actuator_2 = seen.pressures[4 * axis : 4 * axis + 4]
    out_valve, home_valve = (valve_1, valve_2) if direction > 0 else (valve_2, valve_1)
    out_port, home_port = (actuator_1, actuator_2) if direction > 0 else (actuator_2, actuator_1)
    assert now.plant.supply.pressure > out_valve > out_port
    assert home_port > home_valve > 0.0


def test_case_oil_leaves_the_motor_and_never_comes_back(machine):
    p = plant_parameters(machine)
    for volts in (VOLTS, -VOLTS):
        now = compiled_advance()(equilibrium((0.0, 0.5, -1.5), p), (volts, 0.0, 0.0), 1e-3, 700, p)
        assert measure(now, at_rest(now, p), p, 5e-3)[1].of_kind("case_drain")[0] > 0.0
        assert power_flows(now, p).swing.leakage > 0.0
