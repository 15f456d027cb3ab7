"""What the project's commands share: how they read a number, and how they end.

They end with one sentence for what went wrong, and an exit code that scripts can use.
"""

import argparse
import contextlib
import math
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TextIO, TypeAlias

from forest_msgs_py.runtime.stop_signals import heeded

Subcommands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"
Command: TypeAlias = Callable[[argparse.Namespace], int]
"""Takes a subcommand's options, and returns the exit code."""
PIPE_CLOSED = 128 + signal.SIGPIPE  # exit code by which shells know it
LARGEST = 2**31 - 1  # whole number that a flag takes: seeds are as large


def number(low: float, high: float = math.inf, unit: str = "") -> Callable[[str], float]:
    """Return an argument's type: a finite number within bounds."""
    bounds = f"{low:g} or more" if math.isinf(high) else f"{low:g} .. {high:g}"

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not (low <= value <= high and math.isfinite(value)):
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: {f'{bounds} {unit}'.strip()}")
        return value

    return read


def whole(low: int, high: int = LARGEST) -> Callable[[str], int]:
    """Return an argument's type: a whole number within bounds."""

    def read(text: str) -> int:
        if not (text.isdecimal() and low <= int(text) <= high):
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: {low} .. {high}, whole")
        return int(text)

    return read


def output_file(*suffixes: str) -> Callable[[str], Path]:
    """Return an argument's type: a file that can be made, known before the work is done.

    Args:
        suffixes: with which it may end; none: any.
    """

    def read(text: str) -> Path:
        path = Path(text)
        if path.is_dir() or not path.parent.is_dir():
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: a file in a directory that is there")
        if suffixes and path.suffix not in suffixes:
            raise argparse.ArgumentTypeError(f"{text!r}; allowed: a file that ends in {', '.join(suffixes)}")
        return path

    return read


def add_machine_option(parser: argparse.ArgumentParser, default: str = "c180") -> None:
    """Add `--machine`: a shipped name, or a machine file."""
    text = "machine, shipped or a file (default: %(default)s)"
    parser.add_argument("--machine", default=default, metavar="NAME|FILE", help=text)


def subcommand(
    commands: Subcommands,
    name: str,
    text: str,
    command: Command | None = None,
    epilog: str | None = None,
) -> argparse.ArgumentParser:
    """Add a subcommand to a program; return its parser.

    Args:
        commands: of the program.
        name: of the subcommand.
        text: what it does; begins with a small letter, and has no full stop.
        command: of the subcommand; None: it has subcommands itself.
        epilog: behind its arguments' help.
    """
    parser = commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.", epilog=epilog)
    if command is not None:
        parser.set_defaults(command=command)
    return parser


class StatusLine:
    """How far a run is, in one line: on a terminal it overwrites itself, elsewhere each is a line of its own.

    tqdm and rich write bars: elsewhere than on a terminal they write carriage returns into the log, and a
    recording has no end to count towards.

    Args:
        stream: standard output or error.
        log: takes a line where there is no terminal; None: the stream does.
    """

    def __init__(self, stream: TextIO, log: Callable[[str], object] | None = None) -> None:
        self.terminal = stream.isatty()
        self._stream, self._log = stream, log
        self._shown = False

    def show(self, text: str) -> None:
        """Write the line."""
        if self.terminal:
            self._shown = True
            print(f"\r\x1b[K{text}", end="", file=self._stream, flush=True)
        elif self._log is not None:
            self._log(text)
        else:
            print(text, file=self._stream, flush=True)

    def end(self) -> None:
        """Leave the terminal's line as it is, and go to the next."""
        if self._shown:
            print(file=self._stream, flush=True)


def run(program: str, options: argparse.Namespace, errors: tuple[type[Exception], ...]) -> int:
    """Run the subcommand that the options hold as `command`; return the exit code.

    0 as the command says, 1 when it failed (one sentence on stderr), 130 when it was stopped, 141 when nobody
    reads its output any more: it may have had more to do.

    Args:
        program: named in front of what is said.
        options: parsed arguments; `options.command` takes them and returns an exit code.
        errors: exceptions whose text is the sentence; OSError always is one.
    """
    command: Command = options.command
    try:
        with _stopped_as_by_ctrl_c():
            return command(options)
    except KeyboardInterrupt:
        print(f"\n{program}: stopped; what was written until now is kept", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of our output has left
        with contextlib.suppress(OSError):
            sys.stdout.close()
        return PIPE_CLOSED
    except OSError as error:
        named = f"{error.filename}: " if error.filename else ""
        print(f"{program}: {named}{error.strerror or error}", file=sys.stderr)
    except errors as error:
        print(f"{program}: {error}", file=sys.stderr)
    return 1


@contextlib.contextmanager
def path_in_errors(path: Path) -> Iterator[None]:
    """Have errors say where something could not be written; that of a full disk does not by itself."""
    try:
        yield
    except OSError as error:
        if error.filename is not None or error.errno is None:
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextlib.contextmanager
def _stopped_as_by_ctrl_c() -> Iterator[None]:
    """Let `timeout`, a batch system and a terminal that closes stop a command as Ctrl-C does."""
    numbers = heeded((signal.SIGTERM, signal.SIGHUP))
    before = {number: signal.signal(number, signal.default_int_handler) for number in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            if signal.getsignal(number) is signal.default_int_handler:  # a node's end has set its own
                signal.signal(number, handler)
