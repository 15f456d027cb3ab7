"""Claims about the driver's gate: which commands reach the valves."""

import math

import pytest

from forest_control.valve.command_gate import Command, CommandGate, Verdict

ASKED, ZERO = (2.0, 0.0, -1.0), (0.0, 0.0, 0.0)
MS = 1_000_000  # [ns]


class Clock:
    def __init__(self):
        self.now = 10.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def new_gate(clock):
    return CommandGate(0.1, clock)


@pytest.fixture
def gate(new_gate, clock):
    """A gate that has heard zero, longer ago than the timeout."""
    clock.now = 9.85
    new_gate.decide(Command(ZERO, 0, 9.85), False)
    clock.now = 10.0
    return new_gate


def command(values=ASKED, stamp=5 * MS, age=0.0, problem=""):
    return Command(values, stamp, 10.0 - age, problem)


def test_a_good_command_makes_the_driver_step(gate):
    assert gate.decide(command(), False) == Verdict.STEP
    assert gate.problem == ""
    assert not gate.is_lost()


def test_no_two_verdicts_are_one():
    """Members of an enumeration with equal numbers would be the same."""
    assert [int(verdict) for verdict in Verdict] == [0, 1, 2, 3]


def test_before_the_first_command_it_is_lost(new_gate):
    assert new_gate.problem == ""
    assert new_gate.is_lost()
    assert new_gate.against_reset() == ""


def test_a_driver_that_starts_in_mid_motion_moves_nothing_before_a_command_was_zero(new_gate):
    assert new_gate.decide(command(), False) == Verdict.CENTRE
    assert new_gate.problem.startswith("valve_commands: not zero at the start")
    assert new_gate.decide(command(ZERO, stamp=6 * MS), False) == Verdict.STEP
    assert new_gate.decide(command(stamp=7 * MS), False) == Verdict.STEP
    assert new_gate.problem == ""


@pytest.mark.parametrize(("age", "verdict"), [(0.09, Verdict.STEP), (0.11, Verdict.SKIP)])
def test_a_command_left_over_from_a_stall_counts_for_nothing(gate, age, verdict):
    assert gate.decide(command(age=age), False) == verdict
    assert gate.is_lost() == (verdict == Verdict.SKIP)


def test_a_command_is_lost_after_the_timeout(gate, clock):
    gate.decide(command(), False)
    clock.now = 10.09
    assert not gate.is_lost()
    clock.now = 10.11
    assert gate.is_lost()


@pytest.mark.parametrize(("stamp", "said"), [(5 * MS, "stands still"), (4 * MS, "goes back by 0.001 s")])
def test_a_command_out_of_order_moves_nothing_and_is_told(gate, stamp, said):
    gate.decide(command(), False)
    assert gate.decide(command(stamp=stamp), False) == Verdict.REFUSE
    assert said in gate.problem


def test_zero_counts_in_any_order(gate):
    gate.decide(command(), False)
    assert gate.decide(command(ZERO, stamp=4 * MS), False) == Verdict.STEP
    assert gate.problem == ""
    assert gate.against_reset() == ""


def test_a_command_that_cannot_be_read_centres_and_does_not_count(gate):
    assert gate.decide(command((), problem="bad"), False) == Verdict.CENTRE
    assert gate.problem == "bad"
    assert (
        gate.decide(command((math.nan,) * 3, problem=""), False) == Verdict.STEP
    )  # `step` gives zero for it


def test_the_emergency_stop_centres_and_is_not_reset_while_a_command_is_not_zero(gate, clock):
    assert gate.decide(command(), True) == Verdict.CENTRE
    assert gate.against_reset() == "a command is not zero; release the deadman"
    clock.now = 10.11
    assert gate.against_reset() == ""
    clock.now = 10.0
    assert gate.decide(command(ZERO, stamp=6 * MS), True) == Verdict.CENTRE
    assert gate.against_reset() == ""


def later(values, stamp, sent, problem=""):
    return Command(values, stamp * MS, sent, problem)


def test_commands_that_come_back_after_they_were_gone_move_nothing_before_one_was_zero(gate, clock):
    gate.decide(command(), False)
    clock.now = 10.31
    for k in range(3):
        assert gate.decide(later(ASKED, 6 + k, 10.31), False) == Verdict.CENTRE
        assert gate.problem.startswith("valve_commands: not zero at the start or after a gap")
        assert not gate.is_lost()
        assert gate.against_reset() == "a command is not zero; release the deadman"
    assert gate.decide(later(ZERO, 9, 10.31), False) == Verdict.STEP
    assert gate.decide(later(ASKED, 10, 10.31), False) == Verdict.STEP
    assert gate.problem == ""


def test_what_comes_back_as_zero_was_let_go_and_a_gap_of_0_3_s_is_none(gate, clock):
    gate.decide(command(), False)
    clock.now = 10.29
    assert gate.decide(later(ASKED, 6, 10.29), False) == Verdict.STEP
    clock.now = 11.0
    assert gate.decide(later(ZERO, 7, 11.0), False) == Verdict.STEP
    assert gate.decide(later(ASKED, 8, 11.0), False) == Verdict.STEP


def test_unreadable_commands_for_0_3_s_are_a_loss_a_single_one_is_none(gate, clock):
    gate.decide(command(), False)
    gate.decide(command((), problem="bad"), False)
    assert gate.decide(command(stamp=6 * MS), False) == Verdict.STEP
    clock.now = 10.31
    gate.decide(later((), 7, 10.31, "bad"), False)
    assert gate.decide(later(ASKED, 8, 10.31), False) == Verdict.CENTRE


def test_a_controller_that_hangs_for_0_3_s_was_gone(gate, clock):
    gate.decide(command(), False)
    clock.now = 10.31
    assert gate.decide(later(ASKED, 5, 10.31), False) == Verdict.REFUSE
    assert gate.decide(later(ASKED, 6, 10.31), False) == Verdict.CENTRE


def test_what_a_driver_itself_slept_through_was_gone(gate, clock):
    """It finds in its queue what the controller has said meanwhile; the controller has missed it, too."""
    gate.decide(command(), False)
    clock.now = 10.7
    assert gate.decide(later(ASKED, 6, 10.25), False) == Verdict.SKIP
    assert gate.decide(later(ASKED, 7, 10.5), False) == Verdict.SKIP
    assert gate.decide(later(ASKED, 8, 10.7), False) == Verdict.CENTRE
