"""A status line overwrites itself on a terminal; elsewhere each is a line, of the stream or of a log."""

import io

import pytest

from forest_msgs_py.runtime.command_line import StatusLine


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
