"""Keys of a terminal arrive one by one, and the terminal is put back."""

import os
import signal
import subprocess
import sys
import termios
import textwrap

import pytest

from forest_bag.play.keyboard import Keyboard, split_keys

CHILD = textwrap.dedent(
    """
    import os, signal, sys, threading
    from forest_bag.play.keyboard import Keyboard
    terminal = os.open(sys.argv[1], os.O_RDWR)  # a session's first terminal becomes its own
    done = threading.Event()
    def told(name):
        return lambda: print(name, flush=True)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(3))
    actions = {name: told(name) for name in ("space", "up", "+")} | {"q": done.set}
    with Keyboard(actions, terminal) as keys:
        print("ready", keys.active, flush=True)
        done.wait(60)
    """
)


@pytest.mark.parametrize(
    ("text", "keys"),
    [
        (" ", ["space"]),
        ("\x1b[A\x1b[B+", ["up", "down", "+"]),
        ("\x1bOC\x1b[D", ["right", "left"]),
        ("\x1b", ["\x1b"]),
        ("", []),
    ],
)
def test_keys_are_told_apart(text, keys):
    assert split_keys(text) == keys


@pytest.fixture
def terminal():
    """A pseudo-terminal: the user's end, and the name of the program's end."""
    ours, theirs = os.openpty()
    yield ours, theirs
    os.close(ours)
    os.close(theirs)


@pytest.mark.parametrize("ending", ["q", signal.SIGTERM])
def test_the_terminal_is_put_back_however_the_program_ends(terminal, ending):
    ours, theirs = terminal
    before = termios.tcgetattr(theirs)
    command = [sys.executable, "-c", CHILD, os.ttyname(theirs)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True) as child:
        assert child.stdout.readline() == "ready True\n"
        assert not termios.tcgetattr(theirs)[3] & termios.ICANON
        os.write(ours, b" x\x1b[A+")
        assert [child.stdout.readline() for _ in range(3)] == ["space\n", "up\n", "+\n"]
        if ending == "q":
            os.write(ours, b"q")
        else:
            child.send_signal(ending)
        assert child.wait(60) == (0 if ending == "q" else 3)
    assert termios.tcgetattr(theirs) == before


def test_without_a_terminal_nothing_happens():
    reader, writer = os.pipe()
    with Keyboard({}, reader) as keyboard:
        assert not keyboard.active
    os.close(reader)
    os.close(writer)
