"""The stations of docs/explanation/architecture.md are there, and a sample passes them in that order."""

import ast
import re
import sys
from pathlib import Path

import pytest

from forest_control.config import controller_settings
from forest_control.operator import joystick_watch
from forest_control.operator.joystick_watch import Sample
from forest_control.operator.levers import Levers
from forest_control.pipeline.control_state import ValveFeedback
from forest_control.pipeline.guarded_controller import GuardedController
from forest_control.safety.driver_response import DriverSample
from forest_control.safety.motion_permission import MachineState, PermissionParameters
from forest_control.valve import load_estimate, valve_driver, valve_driver_parameters
from forest_control.valve.tracking_limit import FULL
from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_description.types import ZERO
from forest_msgs_py.types import PERIOD, PERIOD_NS
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.simulation.simulated_machine import SimulatedMachine

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "explanation" / "architecture.md").read_text("utf-8")
SHELLS = ("_node.py", "_topics.py")  # need a graph around them
STATION = re.compile(r"^\| .+ \| `(forest_\w+)/([\w/]+\.py)` \| `(\w+)` \|$", re.MULTILINE)


def stations(heading):
    """(file, function) of each row under a heading."""
    section = re.search(rf"^## {heading}$(.*?)^## ", PAGE, re.MULTILINE | re.DOTALL)
    return [(f"{p}/{p}/{file}", function) for p, file, function in STATION.findall(section[1])]


LEVER, VOLTAGE = stations("From a lever to the valve"), stations("From the voltage to the joints")


@pytest.mark.parametrize(("file", "function"), [*LEVER, *VOLTAGE], ids=lambda name: name)
def test_each_station_is_a_function_of_its_file(file, function):
    tree = ast.parse((ROOT / "src" / file).read_text("utf-8"))
    assert function in {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def test_every_file_that_the_page_names_is_there():
    named = re.findall(r"`(forest_\w+)/([\w/]+\.py)`", PAGE)
    assert len(named) > 30
    assert [name for name in named if not (ROOT / "src" / name[0] / name[0] / name[1]).exists()] == []


def calls_of(work):
    """Calls [(file, function)] in order that some work makes."""
    calls, sources = [], str(ROOT / "src") + "/"

    def note(frame, event, _argument):
        name = frame.f_code.co_filename
        if event == "call" and name.startswith(sources):
            calls.append((name.removeprefix(sources), frame.f_code.co_name))

    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
    return calls


def is_in_order(wanted, calls):
    """Whether all that is wanted was called, one after the other."""
    rest = iter(calls)
    return all(any(call == one for call in rest) for one in wanted)


@pytest.fixture
def crane(monkeypatch):
    """A machine whose steps are interpreted, driven for a while with the levers off centre."""
    monkeypatch.setattr("forest_sim.simulation.simulated_machine.ready_advance", lambda: None)
    machine = load_machine("c180_hoses")
    return Crane(machine)


class Crane:
    def __init__(self, machine):
        start = pose_at(start_tip(machine), machine)
        self.simulated = SimulatedMachine(machine, start, sensor_suite(machine, noise=False, seed=0), PERIOD)
        self.controller = GuardedController(
            controller_settings.parameters(machine, controller_settings.Settings()), PermissionParameters()
        )
        self.driver = valve_driver_parameters.parameters(machine, valve_driver_parameters.Settings())
        self.drive, self.voltages, self.report, self.count = valve_driver.REST, ZERO, None, 0

    def period(self, levers):
        """The machine's period, then the controller's and the driver's answer to what it reports."""
        self.count += 1
        now, stamp = PERIOD * self.count, PERIOD_NS * self.count
        self.report = self.simulated.step(self.voltages)
        seen = self.report.seen
        heard = Sample(
            received=now, stamp=stamp, heartbeat=self.count, same=False, good=True, levers=levers, held=True
        )
        self.controller.guard.hear(heard)
        state = MachineState(seen.joints.position, seen.joints.speed, stamp, now)
        feedback = ValveFeedback(FULL, self.voltages, DriverSample(self.voltages, now))
        _, told = self.controller.advance(state, feedback, now)
        at, supply = seen.pressures, seen.supply_pressure
        pressures = load_estimate.Pressures((at[1], at[5], at[9]), (at[3], at[7], at[11]), supply)
        motion = load_estimate.Motion(seen.actuators.position, (at[0], at[4], at[8]), (at[2], at[6], at[10]))
        self.drive, self.voltages = valve_driver.step(
            self.drive, told.output.command, pressures, motion, self.driver, PERIOD
        )


def test_a_sample_passes_the_stations_in_the_order_of_the_page(crane):
    for count in range(40):
        crane.period(Levers(0.0, 0.5, 0.0) if count > 5 else joystick_watch.CENTRED)
    calls = calls_of(lambda: crane.period(Levers(0.0, 0.5, 0.0)))
    assert any(crane.voltages)
    cores = [one for one in LEVER if not one[0].endswith(SHELLS)]
    machine = [one for one in VOLTAGE if not one[0].endswith(SHELLS)]
    assert is_in_order([*machine, *cores], calls)
    assert not is_in_order([*machine, *reversed(cores)], calls)
