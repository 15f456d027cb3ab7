"""Claims about what a simulator tells beside its sensors: of a machine's parts, and of no others."""

import numpy as np
import pytest

from forest_description.derived.limits import pose_at, start_tip
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_sim.sensors.sensor_suite import EXACT_SUITE
from forest_sim.simulation.load_schedule import Load
from forest_sim.simulation.sensor_log import further_topics
from forest_sim.simulation.simulated_machine import SimulatedMachine

PUMP, LINE, OPENINGS, TIP_OVER = (
    topics.GROUND_TRUTH_PUMP,
    topics.GROUND_TRUTH_TANK_LINE,
    topics.GROUND_TRUTH_COMPENSATORS,
    topics.GROUND_TRUTH_TIP_OVER,
)
SHUT, BOOM_UP = (0.0, 0.0, 0.0), (0.0, 6.0, 0.0)


def started(name):
    machine = load_machine(name)
    running = SimulatedMachine(machine, pose_at(start_tip(machine), machine), EXACT_SUITE, period=0.005)
    return running, further_topics(machine, has_loads=False)


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("c180_thesis", set()),
        ("c180_hoses", set()),
        ("c180", {PUMP, LINE}),
        ("forwarder", {PUMP, LINE, OPENINGS, TIP_OVER}),
    ],
)
def test_a_machine_tells_of_the_parts_that_its_file_has(name, told):
    _, further = started(name)
    assert told == {PUMP, LINE, OPENINGS, TIP_OVER} & set(further)


def test_a_pump_that_serves_an_axis_swivels_out_slows_its_engine_and_the_line_fills():
    running, told = started("forwarder")
    for _ in range(200):
        running.step(SHUT)
    (idle, fast), (empty,) = told[PUMP](running), told[LINE](running)
    for _ in range(100):
        running.step(BOOM_UP)
    (displacement, speed), (pressure,) = told[PUMP](running), told[LINE](running)
    assert 0.0 <= idle < 0.5 * displacement <= 0.5
    assert 0.8 * fast < speed < 0.999 * fast
    assert pressure > empty + 1e4
    openings = np.array(told[OPENINGS](running))
    assert openings.min() >= 0.0
    assert openings.max() > 0.1


def test_a_log_takes_from_the_margin_at_the_side_of_the_crane():
    running, told = started("forwarder")
    empty = told[TIP_OVER](running)
    running.hold(Load(900.0, 4.0))
    full = told[TIP_OVER](running)
    side = int(np.argmin(empty))
    assert full[side] < empty[side] - 0.01
    assert min(full) == full[side]


def test_valves_without_compensator_have_no_opening():
    running, _ = started("c180")
    assert np.isnan(running.compensators).all()
