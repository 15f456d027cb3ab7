"""The loop with its monitor: machine code gives what the interpreted cores give, and faults are found."""

import numpy as np
import pytest

from forest_compile.kernel_cache import can_compile
from forest_control.config import controller_settings
from forest_control.valve import valve_driver_parameters
from forest_description.machine import load_machine
from forest_ident.diagnosis import monitor, residual_limits, residual_parameters, residuals
from forest_ident.diagnosis.sequential_test import score
from forest_msgs_py.types import PERIOD
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.hydraulics.actuator import inlet_flow, leaking, outlet_flow
from forest_study.closed_loop import loop_core, loop_kernel
from forest_study.closed_loop.path_guide import Hand
from forest_study.diagnosis import monitored_loop
from forest_study.diagnosis.detection_figures import figures
from forest_study.diagnosis.diagnosis_trial import monitored
from forest_study.diagnosis.faults import CASES, injected, right_causes
from forest_study.diagnosis.population import day
from forest_study.tracking.tracking import noisy

MACHINE = load_machine("c180_hoses")
compiled = pytest.mark.skipif(not can_compile(), reason="llvmlite is not installed")


def interpreted(setting, work, normals):
    """Return the monitor's state after the loop, by the cores themselves."""
    loop, k, watch = setting.loop, setting.knowledge, monitor.BEGIN
    flat = normals.ravel().tolist()
    for row, (x, y, z, speed, doing) in enumerate(work.tolist()):
        plant = loop.simulation.plant
        tip = loop_core.tip_position((plant.swing.angle, plant.boom.angle, plant.stick.angle), k.links)
        levers = monitored_loop.operated(tip, (x, y, z), speed, setting.hand)
        levers = monitored_loop.levers_of.REST if doing < monitored_loop.WORKS else levers
        sensors, seen = loop_core.sensed(loop, k, flat, row)
        volts = loop.drive.voltages
        loop, _ = loop_core.moved(loop, sensors, seen, levers, doing > monitored_loop.HELD, True, k, row)
        watch = monitor.step(
            watch, monitored_loop.read(seen, volts, loop.drive, k.drive), setting.monitor, PERIOD
        )
    return watch


@compiled
def test_machine_code_and_the_cores_agree_to_the_last_bit():
    one, suite = day(MACHINE, 3, 2.0), noisy(MACHINE, 3, static_errors=True)
    control = controller_settings.Settings(tip_speed=1.0)
    k = loop_kernel.knowledge(MACHINE, MACHINE, control, valve_driver_parameters.Settings(), suite)
    p = monitor.Parameters(residual_parameters.parameters(MACHINE), residual_limits.LIMITS)
    setting = monitored_loop.Setting(loop_kernel.begin(k, one.start, suite), k, p, Hand(1.0))
    normals = monitored_loop.draws(suite, len(one.work))
    rows = monitored_loop.run(setting, one.work, normals, {})
    watch = interpreted(setting, one.work, normals)
    expected = [score(test, of) for test, of in zip(watch.tests, residual_limits.LIMITS, strict=True)]
    assert rows[-1, residuals.COUNT : 2 * residuals.COUNT].tolist() == expected
    means = rows[-1, 2 * residuals.COUNT : 3 * residuals.COUNT].tolist()
    assert means == [test.mean for test in watch.tests]
    assert any(means)


@compiled
@pytest.mark.parametrize("case", ["worn pump, severe", "biased transducer, severe", "cold oil, mild"])
def test_a_fault_is_found_named_and_nothing_is_told_before(case):
    run = monitored(MACHINE, 11, 120.0, injected(case, 11), 70.0)
    found = figures(run, right_causes(case, 11))
    assert found["false_alarms"] == 0.0
    assert found["detected"] == found["named"] == found["alone"] == 1.0
    assert found["time_to_detect_s"] < 45.0


@compiled
def test_a_sound_machine_has_only_healthy_hours():
    found = figures(monitored(MACHINE, 12, 60.0, injected("healthy", 12), np.inf), ())
    assert found["healthy_h"] == pytest.approx(60.0 / 3600.0)
    assert found["faulty_h"] == 0.0
    assert np.isnan(found["detected"])


def test_each_case_can_be_injected_and_has_a_name_to_be_found_by():
    for case in CASES:
        for seed in range(3):
            assert bool(right_causes(case, seed)) == (case != "healthy")
            injected(case, seed)


def test_a_worn_cylinder_passes_oil_from_port_to_port_and_a_dripping_one_loses_it():
    sound = plant_parameters(load_machine("c180")).boom.actuator
    worn, drips = leaking(sound, 2e-12, 0.0), leaking(sound, 0.0, 2e-12)
    assert inlet_flow(0.0, 10e6, 2e6, worn) == pytest.approx(2e-12 * 8e6)
    assert outlet_flow(0.0, 10e6, 2e6, worn) == pytest.approx(2e-12 * 8e6)
    assert inlet_flow(0.0, 10e6, 2e6, drips) == pytest.approx(2e-12 * 10e6)
    assert outlet_flow(0.0, 10e6, 2e6, drips) == pytest.approx(-2e-12 * 2e6)
    assert leaking(sound, 0.0, 0.0) == pytest.approx(sound)
