import dataclasses

import numpy as np
import pytest

from forest_compile import flat_layout
from forest_description.machine import load_machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.measurements.session import THERMOCOUPLES, Session
from forest_ident.output_error.prediction import Offsets, plants_at, predict, redrawn, rest, resting_at
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.solver.oil_temperature import parameters_at


@pytest.mark.parametrize("name", ["c180_hoses", "loader"])
def test_between_two_temperatures_the_plant_is_the_one_made_there(name):
    machine = load_machine(name)
    pack = flat_layout.packer(parameters_at(machine, 300.0))
    temperatures = (290.03, 313.48, 331.07)
    for temperature, plant in zip(temperatures, plants_at(machine, temperatures), strict=True):
        assert plant.tolist() == pytest.approx(pack(parameters_at(machine, temperature)), rel=5e-6)


def test_offsets_of_a_hundredth_of_a_kelvin_are_felt():
    """Rounded temperatures would give a fit steps in place of a slope."""
    machine = load_machine("c180_hoses")
    plants = plants_at(machine, np.arange(310.2, 310.3, 0.01).tolist())  # across a change of nodes
    place = flat_layout.packer(plant_parameters(machine))(plant_parameters(machine)).index(
        plant_parameters(machine).swing.actuator.external_leakage
    )
    assert np.all(np.diff(plants[:, place]) > 0.0)


def test_a_prediction_starts_with_its_joints_where_the_resolvers_read_them_though_links_bend():
    p, joints = plant_parameters(load_machine("c180")), (0.2, 0.4, -1.4)
    begin = resting_at(joints, p).plant
    assert [root.angle for root in begin.roots] == pytest.approx(joints, abs=1e-7)
    assert begin.boom.angle < joints[1] - 1e-3  # the boom hangs below its joint


def test_a_row_is_read_with_the_oil_of_its_time():
    machine = load_machine("c180_hoses")
    record = experiment("damping_swing", machine, seed=1, longest=6.0)

    def case_drain(*temperatures):
        warm = np.repeat(temperatures, 400)[: len(record.time)]  # blocks of 2 s
        readings = {**record.readings, **dict.fromkeys(THERMOCOUPLES, warm)}
        return predict(machine, dataclasses.replace(record, readings=readings))["case_drain"]

    one, other = case_drain(313.0, 318.0, 323.0), case_drain(313.0, 318.0, 328.0)
    np.testing.assert_array_equal(one[:801], other[:801])  # the state at a block's end belongs to it
    assert np.all(other[801:811] > one[801:811])  # thinner oil leaks more


def test_an_angle_that_a_record_starts_from_may_be_off_what_is_read():
    machine = load_machine("c180_hoses")
    record = experiment("damping_boom", machine, seed=1, longest=2.0)
    off = predict(machine, record, start={"boom_resolver": 0.01})["boom_resolver"]
    assert off[0] - predict(machine, record)["boom_resolver"][0] == pytest.approx(0.01, abs=1e-9)


def test_a_resolvers_error_moves_the_crane_as_its_start_does_and_the_reading_by_itself():
    """So a fit simulates only one of the two (`Unknown.like`)."""
    machine = load_machine("c180_hoses")
    record = experiment("damping_boom", machine, seed=1, longest=3.0)
    for axis in ("boom", "stick"):
        error = predict(machine, record, Offsets(**{axis: 1e-3}))
        start = predict(machine, record, start={f"{axis}_resolver": 1e-3})
        for name, column in start.items():
            shift = 1e-3 if name == f"{axis}_resolver" else 0.0
            np.testing.assert_allclose(error[name], column - shift, rtol=1e-12, atol=1e-15)


def warm(facts=None, **readings):
    return Session("damping_swing", np.arange(4000) * 0.005, np.zeros((4000, 3)), readings, facts or {})


def test_the_noise_of_thermocouples_is_drawn_once_more_and_nothing_else_changes():
    machine = load_machine("c180_hoses")
    record = warm(tank_temperature=np.full(4000, 315.0), swing_resolver=np.zeros(4000))
    noise, copies = machine.sensors.thermocouple.noise, redrawn(machine, record)
    assert noise > 0.0
    assert len(copies) >= 2
    for copy in copies:
        drawn = copy.readings["tank_temperature"] - 315.0
        assert np.std(drawn) == pytest.approx(noise, rel=0.05)
        assert abs(np.mean(drawn)) < 0.1 * noise
        assert copy.readings["swing_resolver"] is record.readings["swing_resolver"]
        assert copy.voltages is record.voltages
    assert not np.array_equal(copies[0].readings["tank_temperature"], copies[1].readings["tank_temperature"])
    again = redrawn(machine, record)[0].readings["tank_temperature"]
    np.testing.assert_array_equal(copies[0].readings["tank_temperature"], again)


def test_nothing_is_redrawn_where_the_temperature_drives_nothing_or_is_exact():
    machine = load_machine("c180_hoses")
    thermocouple, hot = machine.sensors.thermocouple, {"tank_temperature": np.full(4000, 315.0)}

    def sensing(part):
        return dataclasses.replace(machine, sensors=dataclasses.replace(machine.sensors, thermocouple=part))

    assert redrawn(machine, warm({"exact_sensors": 1.0}, **hot)) == []
    assert redrawn(machine, warm()) == []
    assert redrawn(dataclasses.replace(machine, oil=None), warm(**hot)) == []
    for part in (
        None,
        dataclasses.replace(thermocouple, noise=None),
        dataclasses.replace(thermocouple, noise=0.0),
    ):
        assert redrawn(sensing(part), warm(**hot)) == []


@pytest.mark.parametrize(
    ("first", "creeps", "rows"),
    [(None, True, 1), (None, False, 200), (0, True, 1), (1, False, 1), (150, True, 150), (300, False, 200)],
)
def test_the_start_is_the_mean_of_the_rows_before_the_first_voltage_200_at_most(first, creeps, rows):
    record = warm()
    if first is not None:
        record.voltages[first:, 2] = -0.1
    assert rest(record, creeps) == slice(0, rows)
    assert (
        rest(dataclasses.replace(record, time=record.time[:50], voltages=np.zeros((50, 3))), False).stop == 50
    )
