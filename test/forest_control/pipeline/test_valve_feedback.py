"""What the controller takes from the valve driver's reports, and when it finds that nobody obeys."""

import math

import pytest

pytest.importorskip("rclpy")

from clock_by_hand import HandClock

from forest_control.pipeline.valve_feedback import LEARNT, ValveReports
from forest_control.safety.driver_response import DriverResponse, objection, responds, response
from forest_control.valve.tracking_limit import FULL
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import float_array

C180 = load_machine("c180_hoses")
LOADER = load_machine("loader")
DEADBAND = C180.valve_of(0).law.forward.deadband_voltage
COMMAND, SHUT = (0.0, 2.0, 0.0), (0.0, 0.0, 0.0)
SILENT, DEAF, HEARD = 0.2, 1.5, 0.5  # [s], [s], [V] as docs/explanation/safety.md tells
NOTHING_SAID, UNHEARD = "valve driver: no voltages", "valve driver: keeps the valves shut"
BEGIN = 1000.0  # [s] a clock that started long ago


@pytest.fixture
def pace():
    pace = HandClock()
    pace.time = BEGIN
    return pace


@pytest.fixture
def reports(pace):
    return ValveReports(pace, C180)


@pytest.fixture
def guard(pace, reports):
    return Guard(pace, reports)


def put_status(pace, **learnt):
    """A status as the driver's; what is not told is as the machine's file says."""
    labels = topics.VALVE_DRIVER_STATUS.labels
    as_filed = {label: DEADBAND if label.endswith("deadband") else 1.0 for label in LEARNT}
    told = {**dict.fromkeys(labels, 0.0), **as_filed, **learnt}
    assert len(told) == len(labels)
    pace.put(topics.VALVE_DRIVER_STATUS, float_array(topics.VALVE_DRIVER_STATUS, 0, list(told.values())))


def put_voltages(pace, volts):
    pace.put(topics.VALVE_VOLTAGES, float_array(topics.VALVE_VOLTAGES, 0, volts))


class Guard:
    """What is objected to a driver whose reports are read."""

    def __init__(self, pace, reports):
        self.pace, self.reports, self.driver = pace, reports, DriverResponse()

    def objection(self, command):
        self.driver = response(self.driver, self.reports.read().driver, command, self.pace.time)
        assert responds(self.driver, self.pace.time) == (objection(self.driver, self.pace.time) == "")
        return objection(self.driver, self.pace.time)


def objections(pace, guard, seconds, command, volts):
    """What is objected in each of some seconds' steps; no volts: the driver is silent."""
    said = []
    for _ in range(round(seconds / 0.005)):
        pace.time += 0.005
        if volts is not None:
            put_voltages(pace, volts)
        said.append(guard.objection(command))
    return said


def test_before_anybody_has_spoken_the_valves_are_as_filed_and_shut(reports):
    assert reports.read()[:2] == (FULL, SHUT)


def test_what_the_driver_has_learnt_lowers_the_opening_ratio_of_that_valve_and_way(pace, reports):
    put_status(pace, stick_backward_gain=0.6, swing_forward_deadband=DEADBAND + 0.5)
    ratio = reports.read().opening_ratio
    assert ratio.backward == pytest.approx((1.0, 1.0, 0.6))
    assert ratio.forward[0] < 1.0
    assert ratio.forward[1:] == (1.0, 1.0)


def test_what_was_learnt_is_forgotten_when_the_driver_says_it_no_more(pace, reports):
    put_status(pace, boom_forward_gain=0.5)
    assert reports.read()[0].forward[1] == pytest.approx(0.5)
    pace.time = BEGIN + 1.0
    assert reports.read()[0].forward[1] == pytest.approx(0.5)
    pace.time = BEGIN + 1.01
    assert reports.read()[0] == FULL


def test_voltages_count_for_a_tenth_of_a_second(pace, reports):
    put_voltages(pace, (1.0, -10.0, 3.0))
    assert reports.read()[1] == (1.0, -10.0, 3.0)
    pace.time = 0.0  # so that the bound itself is a number
    put_voltages(pace, (1.0, -10.0, 3.0))
    assert reports.read()[1] == (1.0, -10.0, 3.0)
    pace.time = 0.1
    assert reports.read()[1] == (1.0, -10.0, 3.0)
    pace.time = 0.11
    assert reports.read()[1] == SHUT


def test_a_bad_report_says_nothing(pace, reports, guard):
    put_status(pace, boom_forward_gain=math.nan)
    put_voltages(pace, (math.inf, 0.0, 0.0))
    assert reports.read()[:2] == (FULL, SHUT)
    assert guard.objection(COMMAND) == ""


def test_of_a_driver_that_never_spoke_nothing_is_expected(pace, guard):
    assert responds(DriverResponse(), 0.0)
    assert set(objections(pace, guard, 1.0, COMMAND, None)) == {""}


def test_a_driver_that_falls_silent_is_missed_after_the_timeout_until_it_speaks(pace, guard):
    objections(pace, guard, 0.5, COMMAND, (0.0, 3.0, 0.0))
    said = objections(pace, guard, 0.5, COMMAND, None)
    assert said.index("valve driver: no voltages") * 0.005 == pytest.approx(SILENT, abs=0.006)
    assert said[-1] == "valve driver: no voltages"
    assert objections(pace, guard, 0.005, SHUT, SHUT) == [""]


def test_a_driver_that_keeps_the_valves_shut_is_found_after_a_while(pace, guard):
    """Its commands do not arrive, or somebody else stops it."""
    objections(pace, guard, 0.5, SHUT, SHUT)
    said = objections(pace, guard, 2.0, COMMAND, SHUT)
    assert said.index("valve driver: keeps the valves shut") * 0.005 == pytest.approx(DEAF, abs=0.006)
    assert objections(pace, guard, 0.5, SHUT, SHUT)[-1] == ""


def test_a_command_that_may_be_noise_need_not_open_a_valve(pace, guard):
    assert set(objections(pace, guard, 2.0, (HEARD, 0.0, -HEARD), SHUT)) == {""}


def learnt_of(machine):
    """What a driver that knows only the machine's file says, by its labels."""
    laws = {joint: machine.valve_of(axis).law for axis, joint in enumerate(topics.JOINTS)}
    edges = {
        f"{joint}_{way}": getattr(law, way) for joint, law in laws.items() for way in ("forward", "backward")
    }
    return edges, {f"{name}_deadband": edge.deadband_voltage for name, edge in edges.items()}


@pytest.mark.parametrize("way", ["forward", "backward"])
@pytest.mark.parametrize("axis", range(3), ids=topics.JOINTS)
def test_each_valve_and_way_is_judged_by_its_own_law(pace, axis, way):
    """The loader's differ in all of them."""
    reports, (edges, as_filed) = ValveReports(pace, LOADER), learnt_of(LOADER)
    name = f"{topics.JOINTS[axis]}_{way}"
    wider = as_filed[f"{name}_deadband"] + 0.5
    put_status(pace, **{**as_filed, f"{name}_deadband": wider, f"{name}_gain": 0.8})
    ratio = reports.read().opening_ratio
    span = edges[name].rated_voltage - edges[name].deadband_voltage
    expected = {"forward": [1.0] * 3, "backward": [1.0] * 3}
    expected[way][axis] = 0.8 * (span - 0.5) / span
    assert ratio.forward == pytest.approx(tuple(expected["forward"]))
    assert ratio.backward == pytest.approx(tuple(expected["backward"]))


def test_a_driver_has_its_time_to_speak_and_to_open_a_valve_and_no_more(pace, reports, guard):
    pace.time = 0.0
    put_voltages(pace, (0.0, 3.0, 0.0))
    reports.read()
    assert guard.objection(COMMAND) == ""
    pace.time = SILENT
    assert guard.objection(COMMAND) == ""
    pace.time = SILENT + 1e-3
    assert guard.objection(COMMAND) == NOTHING_SAID
    pace.time = 1.0
    put_voltages(pace, SHUT)
    reports.read()
    assert guard.objection(SHUT) == ""
    pace.time = 1.0 + DEAF
    put_voltages(pace, SHUT)
    reports.read()
    assert guard.objection(COMMAND) == ""
    pace.time = 1.0 + DEAF + 1e-3
    assert guard.objection(COMMAND) == UNHEARD


@pytest.mark.parametrize("sign", [-1.0, 1.0])
@pytest.mark.parametrize("axis", range(3), ids=topics.JOINTS)
def test_any_joint_that_is_not_obeyed_is_found_and_any_open_valve_is_obedience(pace, guard, axis, sign):
    asked = tuple(sign * 0.51 * (i == axis) for i in range(3))
    objections(pace, guard, 0.1, SHUT, SHUT)
    assert objections(pace, guard, 2.0, asked, SHUT)[-1] == UNHEARD
    volts = tuple(sign * 1.2 * (i == axis) for i in range(3))
    assert set(objections(pace, guard, 2.0, asked, volts)) == {""}


def test_a_driver_that_first_speaks_while_motion_is_commanded_is_not_waited_for(pace, guard):
    """The reference would be ahead of the crane by then."""
    assert objections(pace, guard, 0.5, COMMAND, None)[-1] == ""
    assert objections(pace, guard, 0.005, COMMAND, SHUT) == [UNHEARD]


def test_what_the_driver_says_belongs_to_its_step_in_lockstep(pace, reports):
    assert pace.answered == {topics.VALVE_DRIVER_STATUS.name, topics.VALVE_VOLTAGES.name}
