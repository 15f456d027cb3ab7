import numpy as np
import pytest

from forest_description.machine import load_machine
from forest_ident.measurements.readings import lagged, read, true_columns
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors.sensor_model import SensorMemory, sample
from forest_sim.sensors.sensor_readings import surroundings, true_values
from forest_sim.sensors.sensor_suite import CHANNELS, sensor_suite
from forest_sim.simulation.open_loop import Run, start_angles, whole
from forest_sim.simulation.voltage_profiles import thesis
from forest_sim.solver.state_recording import restore


@pytest.mark.parametrize("name", ["c180_thesis", "c180", "loader", "forwarder"])
def test_columns_are_what_the_sensors_see(name):
    machine = load_machine(name)
    p, around = plant_parameters(machine), surroundings(machine)
    run = whole(machine, thesis(), start_angles(machine), Run(2.0))
    columns = true_columns(run.states, p, around)
    for row in (0, 150, 250, 380):
        scalar = dict(zip(CHANNELS, true_values(restore(run.states[row]), p, around), strict=True))
        for channel, value in scalar.items():
            if channel.endswith("_inertial_unit"):  # a fit takes no crane with these
                continue
            assert columns[channel][row] == pytest.approx(value, rel=1e-9, abs=1e-3), channel


def test_columns_are_read_by_the_law_of_the_channel():
    machine = load_machine("c180_hoses")
    suite = sensor_suite(machine, noise=True, seed=5)
    quiet = suite._replace(channels=tuple(c._replace(noise=0.0) for c in suite.channels))
    flow = 2e-4 * np.sin(np.linspace(0.0, 20.0, 400))
    found = read({"swing_flow": flow}, quiet, 0.005)["swing_flow"]
    channel = quiet.channels[CHANNELS.index("swing_flow")]
    state = SensorMemory(flow[0], flow[0])
    for true, reading in zip(flow.tolist(), found.tolist(), strict=True):
        state, expected = sample(channel, state, true, 0.005, 0.0)
        assert reading == pytest.approx(expected, rel=1e-12)


def test_another_run_has_other_noise_from_the_same_units():
    machine = load_machine("c180_hoses")
    suite = sensor_suite(machine, noise=True, seed=5)
    still = {"boom_resolver": np.full(4000, 0.5)}
    one, two = (read(still, suite, 0.005, run)["boom_resolver"] for run in ("a", "b"))
    assert not np.array_equal(one, two)
    assert np.mean(one) == pytest.approx(np.mean(two), abs=2e-5)


def test_a_lag_starts_where_the_signal_does():
    assert lagged(np.full(50, 3.0), 0.01, 0.005) == pytest.approx(np.full(50, 3.0))
