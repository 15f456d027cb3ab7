"""Writes the pages of docs/reference that are made from the code; a test compares them.

Run `python scripts/reference_pages.py` after a change of a topic, a parameter, a machine key or an option.
"""

import argparse
import importlib
import re
import textwrap
from collections.abc import Callable, Iterator
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest import mock

from forest_description.export import machine_keys, machine_numbers
from forest_msgs_py.interfaces import access_policy, topic_reference
from forest_study import parameter_reference

ROOT = Path(__file__).resolve().parents[1]
PAGES = ROOT / "docs" / "reference"
WIDTH = 100
SCRIPTS = ("demo", "graph", "station", "bags")

COMMAND_LINES = """# Command lines

Made by `python scripts/reference_pages.py` from the programs' own parsers; a test compares.
The programs are in `.venv/bin`. `--help` of each program and command tells the same.
Exit codes: [codes](codes.md#exit-codes).
"""
"""What stands above the tables."""


class _FoundError(Exception):
    """Carries a parser out of the program that made it."""


def parser_of(program: ModuleType) -> argparse.ArgumentParser:
    """Return the parser with which a program's `main` reads its arguments."""

    def found(parser: argparse.ArgumentParser, *_: Any) -> None:
        raise _FoundError(parser)

    with mock.patch.object(argparse.ArgumentParser, "parse_args", found):
        try:
            program.main([])
        except _FoundError as carried:
            parser: argparse.ArgumentParser = carried.args[0]
            return parser
    raise TypeError(f"{program.__name__} reads no arguments")


def programs() -> Iterator[argparse.ArgumentParser]:
    """Give the parsers of the scripts and of the installed programs."""
    for name in SCRIPTS:
        (module,) = re.findall(r" -m (\S+) ", (ROOT / "scripts" / f"{name}.sh").read_text("utf-8"))
        yield parser_of(importlib.import_module(module))
    installed = {point.name: point.module for point in entry_points(group="console_scripts")}
    for name in sorted(installed):
        if name.startswith("forest-"):
            yield parser_of(importlib.import_module(installed[name]))


def command_lines() -> str:
    """Return the page of all programs, commands and options."""
    lines = [COMMAND_LINES]
    for parser in programs():
        lines += [f"## {parser.prog}", "", _prose(parser), "", *_arguments(parser)]
        for command, inner in _commands(parser).items():
            lines += [f"### {parser.prog} {command}", "", _prose(inner), "", *_arguments(inner)]
    return "\n".join(lines).rstrip("\n") + "\n"


def _commands(parser: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    found: dict[str, argparse.ArgumentParser] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for name, inner in action.choices.items():
                found[name] = inner
                found |= {f"{name} {verb}": parser for verb, parser in _commands(inner).items()}
    return found


def _prose(parser: argparse.ArgumentParser) -> str:
    return textwrap.fill(parser.description or "", WIDTH, break_on_hyphens=False)


def _arguments(parser: argparse.ArgumentParser) -> list[str]:
    """Return the lines of a parser's table; none where it has nothing but commands."""
    others = (argparse._SubParsersAction, argparse._HelpAction)
    actions = [action for action in parser._actions if not isinstance(action, others)]
    if not actions:
        return []
    return ["| argument | meaning |", "|---|---|", *(_row(parser, action) for action in actions), ""]


def _row(parser: argparse.ArgumentParser, action: argparse.Action) -> str:
    names, value = action.option_strings, _value(action)
    shown = ", ".join(names) + (f" {value}" if value else "") if names else value
    text = (action.help or "") % {**vars(action), "prog": parser.prog}
    needed = " (required)" if names and action.required else ""
    return f"| `{_cell(shown)}` | {_cell(text)}{needed} |"


def _value(action: argparse.Action) -> str:
    """Return the placeholder of an argument's value, with how often it may stand."""
    if action.nargs == 0:
        return ""
    choices = "{" + ",".join(map(str, action.choices)) + "}" if action.choices else ""
    name = action.metavar or choices or (action.dest.upper() if action.option_strings else action.dest)
    if isinstance(name, tuple):
        return " ".join(name)
    return {"?": f"[{name}]", "*": f"[{name} …]", "+": f"{name} …"}.get(str(action.nargs), name)


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


MADE: dict[str, Callable[[], str]] = {
    "sros2-policies.xml": access_policy.policy,
    "topics.md": lambda: topic_reference.markdown() + "\n",
    "parameters.md": lambda: parameter_reference.page() + "\n",
    "machine.md": machine_numbers.document,
    "machine-file.md": machine_keys.document,
    "command-lines.md": command_lines,
}


def main() -> None:
    """Write every page."""
    for name, make in MADE.items():
        (PAGES / name).write_text(make(), encoding="utf-8")


if __name__ == "__main__":
    main()
