"""How the commands end, and how they say how far they are."""

import argparse
import io
import os
import signal
import sys

import pytest

from forest_msgs_py.runtime import command_line
from forest_msgs_py.runtime.command_line import StatusLine
from forest_msgs_py.runtime.stop_signals import STOP_SIGNALS, heeded


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_on_a_terminal_the_line_overwrites_itself_and_is_left_at_the_end():
    stream = Terminal()
    line = StatusLine(stream, pytest.fail)
    line.show("one")
    line.show("two")
    line.end()
    assert stream.getvalue() == "\r\x1b[Kone\r\x1b[Ktwo\n"


def test_elsewhere_each_is_a_line_of_the_stream_or_of_the_log():
    stream, log = io.StringIO(), []
    for line in (StatusLine(stream), StatusLine(stream, log.append)):
        line.show("one")
        line.end()
    assert (stream.getvalue(), log) == ("one\n", ["one"])


def ended(command):
    """The exit code of a command."""
    return command_line.run("forest", argparse.Namespace(command=command), ())


@pytest.fixture
def hang_up():
    """Sets what a hang-up does, as a terminal or `nohup` does."""
    before = signal.getsignal(signal.SIGHUP)
    yield lambda handler: signal.signal(signal.SIGHUP, handler)
    signal.signal(signal.SIGHUP, before)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_a_command_that_is_told_to_stop_closes_its_files_and_says_so(capsys, hang_up, number):
    hang_up(signal.SIG_DFL)
    handlers, closed = [signal.getsignal(one) for one in STOP_SIGNALS], []

    def command(_):
        try:
            os.kill(os.getpid(), number)
        finally:
            closed.append("bag")
        return 0

    assert ended(command) == 130
    assert closed == ["bag"]
    assert "forest: stopped; what was written until now is kept" in capsys.readouterr().err
    assert [signal.getsignal(one) for one in STOP_SIGNALS] == handlers


def test_a_command_under_nohup_outlives_its_terminal(hang_up):
    hang_up(signal.SIG_IGN)
    assert ended(lambda _: os.kill(os.getpid(), signal.SIGHUP) or 0) == 0
    assert heeded() == (signal.SIGINT, signal.SIGTERM)
    hang_up(signal.SIG_DFL)
    assert heeded() == STOP_SIGNALS


def test_a_node_that_has_ended_within_a_command_keeps_its_exit_code():
    before = signal.getsignal(signal.SIGTERM)
    try:
        assert ended(lambda _: signal.signal(signal.SIGTERM, signal.SIG_IGN) and 0) == 0
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, before)


def test_a_command_whose_reader_has_left_has_not_done_well(monkeypatch):
    monkeypatch.setattr(sys, "stdout", io.StringIO())

    def command(_):
        raise BrokenPipeError

    assert ended(command) == 141
