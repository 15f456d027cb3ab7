"""Claims about the sensors: what they report follows from the true state as it would on a real machine."""

import dataclasses
import math
import time

import numpy as np
import pytest

from forest_description.geometry.linkage import cylinder_length, lever_arm
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors import sensor_readings
from forest_sim.sensors.sensor_suite import CHANNELS, EXACT_SUITE, draw, noise_generator, sensor_suite
from forest_sim.sensors.signal_processing import SPEED_BANDWIDTH
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium

MACHINE, THESIS = load_machine("c180_hoses"), load_machine("c180_thesis")
P = plant_parameters(MACHINE)
Q = (0.3, 0.5, -1.5)
REST = equilibrium(Q, P)
DT = 0.005
LABELS = topics.PRESSURES.labels
D = MACHINE.swing.gear_ratio * MACHINE.swing.motor_displacement


def measure(simulation, before=None):
    return sensor_readings.measure(simulation, before or sensor_readings.at_rest(simulation, P), P, DT)


def watch(simulation, suite, count, dt=DT):
    """What a suite says of a machine that stands still, `count` times."""
    state, generator, said = sensor_readings.at_rest(simulation, P, suite), noise_generator(suite), []
    for _ in range(count):
        state, seen = sensor_readings.measure(simulation, state, P, dt, suite, draw(generator))
        said.append(seen)
    return said


def moving(voltages, seconds):
    return compiled_advance()(REST, voltages, 1e-3, round(seconds * 1000), P)


def turned(simulation, by):
    """The same state with the swing turned [rad]."""
    swing = simulation.plant.swing
    return simulation._replace(plant=simulation.plant._replace(swing=swing._replace(angle=swing.angle + by)))


def pressures(seen):
    return dict(zip(LABELS, seen.pressures, strict=True))


def test_at_rest_positions_are_true_and_speeds_zero():
    _, seen = measure(REST)
    lengths = (cylinder_length(Q[1], P.boom_linkage), cylinder_length(Q[2], P.stick_linkage))
    assert seen.joints.position == Q
    assert seen.actuators.position == (Q[0], *lengths)
    assert seen.joints.speed == seen.actuators.speed == (0.0, 0.0, 0.0)


def test_the_estimate_approaches_a_steady_speed_as_a_first_order_low_pass():
    estimate, simulation = sensor_readings.at_rest(REST, P), REST
    keep = math.exp(-2.0 * math.pi * SPEED_BANDWIDTH * DT)
    for k in range(1, 40):
        simulation = turned(simulation, 0.4 * DT)
        estimate, seen = measure(simulation, estimate)
        assert seen.joints.speed[0] == pytest.approx(0.4 * (1.0 - keep**k), rel=1e-6)
        assert seen.joints.speed[1:] == (0.0, 0.0)
    assert seen.joints.speed[0] == pytest.approx(0.4, rel=1e-3)


def test_speeds_come_from_sampled_positions_and_not_from_the_true_rate():
    swing = REST.plant.swing._replace(rate=0.7)
    rushing = REST._replace(plant=REST.plant._replace(swing=swing))
    _, seen = measure(rushing, sensor_readings.at_rest(REST, P))
    assert seen.joints.speed == seen.actuators.speed == (0.0, 0.0, 0.0)
    assert sensor_readings.true_joints(rushing, P).speed == (0.7, 0.0, 0.0)


def test_cylinder_speed_is_the_joints_times_its_lever_arm():
    before = moving((0.0, 3.0, -3.0), 1.0)
    estimate, state = sensor_readings.at_rest(before, P), before
    for _ in range(60):
        state = compiled_advance()(state, (0.0, 3.0, -3.0), 1e-3, 5, P)
        estimate, seen = measure(state, estimate)
    for joint, linkage in ((1, P.boom_linkage), (2, P.stick_linkage)):
        arm = lever_arm(seen.joints.position[joint], linkage)
        assert seen.actuators.speed[joint] == pytest.approx(arm * seen.joints.speed[joint], rel=1e-2)
        assert abs(seen.actuators.speed[joint]) > 1e-2


def test_forces_are_those_of_the_reported_actuator_pressures():
    seen = measure(moving((4.0, 3.0, -3.0), 0.7))[1]
    p = pressures(seen)
    for i, (axis, a_1, a_2) in enumerate(
        [
            ("swing", D, D),
            ("boom", MACHINE.boom.head_area, MACHINE.boom.rod_area),
            ("stick", MACHINE.stick.head_area, MACHINE.stick.rod_area),
        ]
    ):
        one, two = a_1 * p[f"{axis}_1_actuator"], a_2 * p[f"{axis}_2_actuator"]
        assert seen.actuators.effort[i] == pytest.approx(one - two, abs=1e-9 * (abs(one) + abs(two)))


def test_joint_torques_are_forces_times_lever_arms_for_sensors_and_truth_alike():
    state = moving((4.0, 3.0, -3.0), 0.7)
    seen, true = measure(state)[1], sensor_readings.true_joints(state, P)
    q = seen.joints.position
    arms = (1.0, lever_arm(q[1], P.boom_linkage), lever_arm(q[2], P.stick_linkage))
    assert seen.joints.effort == pytest.approx(np.multiply(arms, seen.actuators.effort), rel=1e-12)
    assert true.effort == pytest.approx(seen.joints.effort, rel=1e-12)


def test_held_by_trapped_oil_the_four_pressures_of_a_cylinder_are_its_two_hoses():
    p = pressures(measure(REST)[1])
    for axis, state in (("boom", REST.plant.boom), ("stick", REST.plant.stick)):
        assert p[f"{axis}_1_valve"] == p[f"{axis}_1_actuator"] == state.pressure_1
        assert p[f"{axis}_2_valve"] == p[f"{axis}_2_actuator"] == state.pressure_2
    assert REST.plant.boom.pressure_1 != REST.plant.stick.pressure_1


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_on_its_way_the_oil_loses_pressure_from_pump_to_valve_to_actuator_and_back(sign):
    seen = measure(moving((sign * 6.0, sign * 6.0, sign * 6.0), 1.0))[1]
    p, supply = pressures(seen), seen.supply_pressure
    for axis in ("swing", "boom", "stick"):
        inlet, outlet = (1, 2) if sign > 0 else (2, 1)
        assert supply > p[f"{axis}_{inlet}_valve"] > p[f"{axis}_{inlet}_actuator"]
        assert p[f"{axis}_{outlet}_actuator"] > p[f"{axis}_{outlet}_valve"] > 0.0


def test_pressure_behind_a_valve_in_steady_motion_is_that_of_its_hose():
    """What is left between them is the hose's inertance, which steady flow does not feel."""
    state = moving((6.0, 0.0, 0.0), 3.0)
    p = pressures(measure(state)[1])
    assert p["swing_1_valve"] == pytest.approx(state.plant.swing.pressure_1, rel=1e-3)
    assert p["swing_2_valve"] == pytest.approx(state.plant.swing.pressure_2, rel=1e-3)


def test_meters_are_at_port_1_of_swing_and_stick():
    state = moving((4.0, 3.0, -3.0), 0.7)
    flows = dict(zip(topics.FLOWS.labels, measure(state)[1].of_kind("flow_meter"), strict=True))
    assert flows == {"swing_1": state.plant.swing.flow_1, "stick_1": state.plant.stick.flow_1}
    assert flows["swing_1"] > 0.0 > flows["stick_1"]


def test_the_pump_gives_what_the_ports_on_its_side_take():
    state = moving((4.0, 3.0, -3.0), 0.7)
    seen, plant = measure(state)[1], state.plant
    assert seen.supply_flow == pytest.approx(plant.swing.flow_1 + plant.boom.flow_1 - plant.stick.flow_2)
    assert seen.supply_flow > max(plant.swing.flow_1, plant.boom.flow_1, -plant.stick.flow_2) > 0.0
    assert seen.supply_pressure == plant.supply.pressure < P.supply.set_pressure


def test_case_drain_is_both_motor_pressures_over_the_external_leakage():
    seen = measure(moving((4.0, 0.0, 0.0), 1.0))[1]
    p = pressures(seen)
    leaked = (p["swing_1_actuator"] + p["swing_2_actuator"]) / MACHINE.swing.external_leakage_resistance
    assert seen.of_kind("case_drain") == pytest.approx((leaked,), rel=1e-6)
    assert leaked > 0.0


def test_true_values_stand_in_the_order_of_the_channels():
    state = moving((4.0, 3.0, -3.0), 0.7)
    around = sensor_readings.Surroundings(261.0, (310.0, 320.0, 330.0), (0.01, 0.02))
    true = dict(zip(CHANNELS, sensor_readings.true_values(state, P, around), strict=True))
    assert [true[f"{axis}_resolver"] for axis in topics.JOINTS] == [s.angle for s in state.plant[:3]]
    assert true["stick_transducer"] == cylinder_length(state.plant.stick.angle, P.stick_linkage)
    seen = sensor_readings.measure(state, sensor_readings.at_rest(state, P), P, DT, around=around)[1]
    for label, value in pressures(seen).items():
        axis, place = label.split("_", 1)
        assert true[f"{axis}_pressure_{place}"] == value
    assert (true["supply_pressure"], (true["case_drain"],)) == (
        seen.supply_pressure,
        seen.of_kind("case_drain"),
    )
    assert (true["swing_flow"], true["stick_flow"]) == seen.of_kind("flow_meter")
    assert tuple(true[f"{axis}_spool"] for axis in topics.JOINTS) == seen.of_kind("spool_sensor")
    assert seen.of_kind("spool_sensor") == tuple(spool.position for spool in state.spools)
    assert tuple(true[f"{part}_temperature"] for part in ("tank", "pump", "motor")) == (310.0, 320.0, 330.0)
    assert seen.of_kind("thermocouple") == (310.0, 320.0, 330.0)
    assert (*seen.of_kind("tachometer"), *seen.of_kind("inclinometer")) == (261.0, 0.01, 0.02)


def test_surroundings_are_nominal_with_the_platforms_tilt():
    tilted = dataclasses.replace(
        MACHINE, manipulator=dataclasses.replace(MACHINE.manipulator, platform_tilt=0.1)
    )
    around = sensor_readings.surroundings(tilted)
    assert around.engine_speed == MACHINE.pump.shaft_speed
    assert sensor_readings.surroundings(THESIS).engine_speed * 60.0 / (2.0 * math.pi) == pytest.approx(2500.0)
    assert around.temperatures == (313.15,) * 3
    assert around.tilt == (0.0, 0.1)


def test_a_suite_without_noise_says_exactly_what_no_suite_says():
    state = moving((4.0, 3.0, -3.0), 0.7)
    said, exact = watch(state, sensor_suite(MACHINE), 3)[-1], watch(state, EXACT_SUITE, 3)[-1]
    read = [number for number in said.readings if not math.isnan(number)]  # of kinds that the machine has
    assert len(read) > 20
    assert set(read) <= set(exact.readings)
    assert said._replace(readings=()) == exact._replace(readings=())


def test_with_noise_angles_scatter_about_a_static_error_within_the_accuracy():
    angles = np.array([seen.joints.position for seen in watch(REST, sensor_suite(MACHINE, True, 1), 5000)])
    assert angles.std(axis=0) == pytest.approx([2e-4] * 3, rel=0.05)
    errors = angles.mean(axis=0) - Q
    assert np.all(np.abs(errors) < math.radians(7 / 60))
    assert np.all(np.abs(errors) > 1e-5)


def test_equal_seeds_say_the_same_and_other_seeds_something_else():
    one, same, other = (watch(REST, sensor_suite(MACHINE, True, seed), 5) for seed in (1, 1, 2))
    assert one == same
    assert not set(one[-1].joints.position) & set(other[-1].joints.position)


def test_a_meter_of_oil_at_rest_shows_its_floor():
    meter = THESIS.sensors.flow_meter
    for seen in watch(REST, sensor_suite(THESIS, True), 20):
        assert seen.of_kind("flow_meter") == (meter.lowest, meter.lowest)


def test_a_meter_shows_63_percent_of_a_step_after_10_ms():
    suite = sensor_suite(THESIS, True)
    flowing = moving((6.0, 0.0, 0.0), 3.0)
    state = sensor_readings.at_rest(REST, P, suite)
    for _ in range(2):
        state, seen = sensor_readings.measure(flowing, state, P, DT, suite)
    true = flowing.plant.swing.flow_1
    assert true > 5.0 * THESIS.sensors.flow_meter.lowest
    assert seen.of_kind("flow_meter")[0] == pytest.approx((1.0 - math.exp(-1.0)) * true, rel=6e-4)


def test_between_samples_readings_are_held_and_speeds_too():
    slow = dataclasses.replace(MACHINE, sensors=dataclasses.replace(MACHINE.sensors, sample_rate=50.0))
    suite = sensor_suite(slow, True, 1)
    said = watch(REST, suite, 16)
    angles = [seen.joints.position[0] for seen in said]
    assert len(set(angles[3:])) == len(angles[3:]) // 4 + 1
    for first in (3, 7, 11):
        assert len({seen.pressures for seen in said[first : first + 4]}) == 1
        assert len({seen.joints.speed for seen in said[first : first + 4]}) == 1


def test_one_sample_of_all_sensors_fits_into_a_fraction_of_a_period():
    """Interpreted, with noise. The limit is a tenth of a period: the machine may be busy."""
    suite = sensor_suite(MACHINE, True)
    state, generator, best = sensor_readings.at_rest(REST, P, suite), noise_generator(suite), math.inf
    for _ in range(300):
        begun = time.thread_time()
        sensor_readings.measure(REST, state, P, DT, suite, draw(generator))
        best = min(best, time.thread_time() - begun)
    assert best < 5e-4


def test_the_tachometer_tells_the_engines_speed_on_a_crane_whose_links_bend_too():
    forwarder = plant_parameters(load_machine("forwarder"))
    rest = equilibrium(Q, forwarder)
    told = sensor_readings.true_values(rest, forwarder, sensor_readings.NOMINAL)
    assert told[CHANNELS.index("engine_speed")] == rest.plant.pump.speed > 0.0
