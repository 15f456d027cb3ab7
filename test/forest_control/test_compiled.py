"""The compiled steps are the interpreted ones to the last bit, of every machine; without code, these run."""

import math

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_compile.kernel_cache import CachedKernel
from forest_control import compiled
from forest_control.config import controller_settings
from forest_control.operator.levers import Levers
from forest_control.pipeline import control_state, controller
from forest_control.servo.joint_angle_filter import UNREAD
from forest_control.servo.schemes import Scheme
from forest_control.valve import load_estimate, valve_driver, valve_driver_parameters
from forest_description.machine import load_machine

DT = 0.005
MACHINES = "c180_hoses", "c180_thesis", "c180"


def walk(seed, count, low, high):
    """Random walks from low to high, one in a row."""
    steps = np.random.default_rng(seed).normal(0.0, 0.05, (count, len(low))).cumsum(axis=0)
    return (np.add(low, high) / 2 + np.subtract(high, low) / 2 * np.sin(steps)).tolist()


def control_inputs(seed, count=150):
    """Levers, angles, rates and pressures that wander, a deadman let go, transducers that come and go."""
    rows = walk(
        seed, count, [-1, 0, -2, -1, -1, -1, -1, -1, -1, 5e6, 1e6], [1, 1, -0.5, 1, 1, 1, 1, 1, 1, 2e7, 5e6]
    )
    for k, row in enumerate(rows):
        lengths = UNREAD if k % 7 == 3 else (1.9, 1.7)
        pressures = (math.nan, math.nan) if k % 11 == 5 else tuple(row[9:])
        held = k % 50 < 40
        inputs = control_state.Inputs(tuple(row[:3]), tuple(row[3:6]), Levers(*row[6:9]), held, lengths)
        yield inputs._replace(boom_pressures=pressures)


def run(step, state, p, arguments):
    """The outputs of a session; what the operator changes half way is told as the node tells it."""
    told = []
    for k, inputs in enumerate(arguments):
        if k == 75 and isinstance(p, controller_settings.Parameters):
            p = p._replace(following_error_limit=0.5 * p.following_error_limit)
            state = state._replace(changed=True)
        state, output = step(state, *inputs, p, DT)
        told.append(output)
    return told, state.built if hasattr(state, "built") else state


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("scheme", list(Scheme))
def test_the_controllers_step_is_the_interpreted_one(machine, scheme):
    compiled.CONTROLLER.kernel()
    p = controller_settings.parameters(load_machine(machine), controller_settings.Settings(scheme=scheme))
    inputs = [(one,) for one in control_inputs(int(scheme))]
    fast = run(compiled.controller_step(), control_state.REST, p, inputs)
    assert fast == run(controller.step_with_telemetry, control_state.REST, p, inputs)
    assert len({told.output.command for told in fast[0]}) > 50


@pytest.mark.parametrize("machine", MACHINES)
@pytest.mark.parametrize("adapt", [False, True])
def test_the_drivers_step_is_the_interpreted_one(machine, adapt):
    compiled.DRIVER.kernel()
    p = valve_driver_parameters.parameters(
        load_machine(machine), valve_driver_parameters.Settings(adapt=adapt)
    )
    rows = walk(5, 300, [-9] * 3 + [1e5] * 12 + [8e6] + [-1] * 3, [9] * 3 + [18e6] * 12 + [2e7] + [1] * 3)
    inputs = []
    for k, row in enumerate(rows):
        seen = load_estimate.Pressures(tuple(row[3:6]), tuple(row[6:9]), row[15])
        motion = load_estimate.Motion(tuple(row[16:]), tuple(row[9:12]), tuple(row[12:15]))
        unseen = k % 60 > 50
        pressures = load_estimate.UNSEEN if unseen else seen
        inputs.append((tuple(row[:3]), pressures, load_estimate.STILL if unseen else motion))
    fast = run(compiled.driver_step(), valve_driver.REST, p, inputs)
    assert fast == run(valve_driver.step, valve_driver.REST, p, inputs)
    assert len(set(fast[0])) > 100


def test_a_state_stays_what_it_was_when_the_step_moves_on():
    compiled.DRIVER.kernel()
    p = valve_driver_parameters.parameters(load_machine("c180_hoses"), valve_driver_parameters.Settings())
    step, unseen = compiled.driver_step(), (load_estimate.UNSEEN, load_estimate.STILL)
    first, _ = step(valve_driver.REST, (1.0, 0.0, 0.0), *unseen, p, DT)
    second, volts = step(first, (2.0, 0.0, 0.0), *unseen, p, DT)
    assert first.voltages != second.voltages
    again, repeated = step(first, (2.0, 0.0, 0.0), *unseen, p, DT)
    assert (again.built, repeated) == (second.built, volts)


def test_without_the_code_the_interpreted_steps_run(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    for name in ("CONTROLLER", "DRIVER"):
        known = getattr(compiled, name).entry
        monkeypatch.setattr(compiled, name, CachedKernel(name, lambda known=known: known))
    assert compiled.controller_step() is controller.step_with_telemetry
    assert compiled.driver_step() is valve_driver.step
