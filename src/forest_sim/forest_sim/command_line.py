"""How the project's commands end: one sentence for what went wrong, and an exit code that scripts can use."""

import argparse
import contextlib
import sys
from collections.abc import Callable


def run(program: str, options: argparse.Namespace, errors: tuple[type[Exception], ...]) -> int:
    """Run the subcommand that the options hold as `command`; return the exit code.

    0 as the command says, 1 when it failed (one sentence on stderr), 130 when it was stopped.

    Args:
        program: named in front of what is said.
        options: parsed arguments; `options.command` takes them and returns an exit code.
        errors: exceptions whose text is the sentence; OSError always is one.
    """
    command: Callable[[argparse.Namespace], int] = options.command
    try:
        return command(options)
    except KeyboardInterrupt:
        print(f"\n{program}: stopped; what was written until now is kept", file=sys.stderr)
        return 130
    except BrokenPipeError:  # the reader of our output has left
        with contextlib.suppress(OSError):
            sys.stdout.close()
        return 0
    except OSError as error:
        named = f"{error.filename}: " if error.filename else ""
        print(f"{program}: {named}{error.strerror or error}", file=sys.stderr)
    except errors as error:
        print(f"{program}: {error}", file=sys.stderr)
    return 1
