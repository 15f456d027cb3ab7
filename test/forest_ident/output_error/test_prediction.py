import numpy as np
import pytest

from forest_compile import flat_layout
from forest_description.machine import load_machine
from forest_ident.output_error.prediction import plants_at, resting_at
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver.oil_temperature import parameters_at


@pytest.mark.parametrize("name", ["c180_hoses", "loader"])
def test_between_two_temperatures_the_plant_is_the_one_made_there(name):
    machine = load_machine(name)
    pack = flat_layout.packer(parameters_at(machine, 300.0))
    for temperature, plant in zip(
        (290.03, 313.15, 331.07), plants_at(machine, (290.03, 313.15, 331.07)), strict=True
    ):
        made = parameters_at(machine, temperature)
        assert pack(plant) == pytest.approx(pack(made), rel=1e-5)
        assert [type(x) for x in pack(plant)] == [type(x) for x in pack(made)]


def test_offsets_of_a_hundredth_of_a_kelvin_are_felt():
    """Rounded temperatures would give a fit steps in place of a slope."""
    machine = load_machine("c180_hoses")
    plants = plants_at(machine, np.arange(310.0, 310.1, 0.01).tolist())
    assert np.all(np.diff([p.swing.actuator.external_leakage for p in plants]) > 0.0)


def test_a_prediction_starts_with_its_joints_where_the_resolvers_read_them_though_links_bend():
    p, joints = plant_parameters(load_machine("c180")), (0.2, 0.4, -1.4)
    begin = resting_at(joints, p).plant
    assert [root.angle for root in begin.roots] == pytest.approx(joints, abs=1e-7)
    assert begin.boom.angle < joints[1] - 1e-3  # the boom hangs below its joint
