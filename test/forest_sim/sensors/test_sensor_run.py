"""Sensors as machine code say what interpreted ones say, to the last bit."""

import dataclasses

import pytest

pytest.importorskip("llvmlite")

from forest_compile.kernel_cache import CachedKernel
from forest_description.machine import load_machine
from forest_description.sensors.sensor_kinds import InertialUnit
from forest_sim.equations.plant_parameters import plant_parameters
from forest_sim.sensors import sensor_run
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.sensors.sensor_readings import surroundings
from forest_sim.sensors.sensor_run import SensorRun
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.solver.compiled_plant import compiled_advance
from forest_sim.solver.equilibrium import equilibrium

DT = 0.005
FAULTS = "boom_resolver: drop 30 %; swing_flow: absent; stick_pressure_1_valve: frozen from 0.1 s until 0.2 s"

HOSES = load_machine("c180_hoses")
UNIT = InertialUnit(1.0, 1.0, 5.0, 0.005, 0.002, 0.001, 0.01)
CABLE = dataclasses.replace(HOSES.sensors.linear_transducer, play=3e-4, accuracy=1e-3)
MACHINES = {
    name: dataclasses.replace(HOSES, sensors=dataclasses.replace(HOSES.sensors, **changes))
    for name, changes in {
        "by length": {"linear_transducer": CABLE, "joint_angles": "linear_transducer"},
        "by inertia": {"inertial_unit": UNIT, "joint_angles": "inertial_unit"},
    }.items()
}


def reports(machine, noise, faults=""):
    """What the sensors say of a machine whose valves are opened, whose plant changes half way."""
    suite, plant = sensor_suite(machine, noise, 3, parse_faults(faults)), plant_parameters(machine)
    simulation, around, said = equilibrium((0.3, 0.5, -1.5), plant), surroundings(machine), []
    run = SensorRun(simulation, plant, machine.manipulator.links, suite, around)
    for k in range(80):
        if k == 40:
            around = around._replace(temperatures=(320.0, 321.0, 322.0))
            run.set_plant(plant._replace(tip_force=(0.0, 0.0, -500.0)), around)
        simulation = compiled_advance()(simulation, (3.0, -2.0, 2.5), 1e-3, 5, plant)
        said.append(run.sample(simulation, DT))
    return said


@pytest.mark.parametrize(
    ("name", "noise", "faults"),
    [
        ("c180_hoses", False, ""),
        ("c180_hoses", True, FAULTS),
        ("c180_thesis", True, ""),
        ("c180_hoses", False, FAULTS),
        ("by length", True, FAULTS),
        ("by inertia", True, "boom_inertial_unit: drop 30 %"),
    ],
)
def test_machine_code_reads_what_the_interpreted_sensors_read(monkeypatch, tmp_path, name, noise, faults):
    machine = MACHINES[name] if name in MACHINES else load_machine(name)
    sensor_run.KERNEL.kernel()
    fast = reports(machine, noise, faults)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))  # where no code is
    entry = sensor_run.KERNEL.entry
    monkeypatch.setattr(sensor_run, "KERNEL", CachedKernel("sensors", lambda: entry))
    assert repr(fast) == repr(reports(machine, noise, faults))  # NaN is no equal of itself
    assert fast[-1].joints.position != fast[0].joints.position
