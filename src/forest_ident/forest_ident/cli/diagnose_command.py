"""`forest-ident diagnose`: what is wrong with the machine, from a bag of everyday work."""

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from forest_description.machine import load_machine
from forest_ident.diagnosis import monitor, residual_parameters
from forest_ident.diagnosis.findings import Finding, alarms, findings
from forest_ident.diagnosis.recorded_readings import samples
from forest_ident.diagnosis.residual_limits import LIMITS
from forest_ident.diagnosis.residuals import NAMES
from forest_ident.measurements.session import SessionError
from forest_msgs_py.runtime.command_line import Subcommands, output_file, subcommand

EVERY = 1.0  # [s] between two looks at what is found
FOUND = 1  # exit code


class Told(NamedTuple):
    """A finding, since when it was there, and for how long."""

    finding: Finding
    first: float  # [s]
    seconds: int


def add_parser(verbs: Subcommands) -> None:
    """Name the verb's flags."""
    text = "tell what is wrong with the machine, from bags of everyday work"
    parser = subcommand(verbs, "diagnose", text, run)
    parser.add_argument("bags", type=Path, nargs="+", metavar="BAG", help="bags, in order of time")
    parser.add_argument("--machine", required=True, metavar="NAME|FILE", help="machine of the bags")
    text = "reference bag of the machine in good health, learnt from first; may be repeated"
    parser.add_argument("--healthy", type=Path, action="append", default=[], metavar="BAG", help=text)
    parser.add_argument(
        "--out", type=output_file(), metavar="FILE", help="JSON file to be made, with findings and residuals"
    )


def run(options: argparse.Namespace) -> int:
    """Run the verb; return its exit code: 1 where something is wrong.

    Raises:
        SessionError: a bag lacks angles or voltages, or the file is there.
        MachineError: there is no such machine.
    """
    if options.out is not None and options.out.exists():
        raise SessionError(f"{options.out} exists already; choose another --out or remove it")
    p = monitor.Parameters(residual_parameters.parameters(load_machine(options.machine)), LIMITS)
    state = monitor.BEGIN
    for bag in options.healthy:
        *_, (state, _) = watched(state, bag, p)
    state, told, time = monitor.quiet(state), dict[tuple[str, str], Told](), 0.0
    for bag in options.bags:
        begun = time
        for after, now in watched(state, bag, p):
            state, time = after, begun + now
            for one in findings(alarms(after, p)):
                key = one.part, one.cause
                before = told.get(key, Told(one, time, 0))
                told[key] = Told(one, before.first, before.seconds + 1)
    found = sorted(told.values(), key=lambda one: -one.seconds)
    print(text(found, state, time))
    if options.out is not None:
        options.out.write_text(json.dumps(_report(found, state), indent=2) + "\n", encoding="utf-8")
        print(f"  {options.out}")
    return FOUND if found else 0


def watched(state: monitor.State, bag: Path, p: monitor.Parameters) -> Iterator[tuple[monitor.State, float]]:
    """Yield the monitor's state and the time [s], once a second of a bag and at its end."""
    look, now = EVERY, 0.0
    for now, dt, readings in samples(bag):
        state = monitor.step(state, readings, p, dt)
        if now >= look:
            look += EVERY
            yield state, now
    yield state, now


def text(found: list[Told], state: monitor.State, time: float) -> str:
    """Return what a person is told."""
    judged = sum(test.seen > 0.0 for test in state.tests)
    about = f"{judged} of {len(NAMES)} residuals had values in {time:.0f} s"
    if not found:
        return f"nothing found: {about}"
    lines = [f"{len(found)} found: {about}"]
    for finding, first, seconds in found:
        lines += [
            f"  from {first:.0f} s, for {seconds} s, {finding.score:.1f} x its threshold",
            f"    {finding}",
        ]
    return "\n".join(lines)


def _report(found: list[Told], state: monitor.State) -> dict[str, Any]:
    return {
        "findings": [
            {**finding._asdict(), "first_s": first, "seconds": seconds} for finding, first, seconds in found
        ],
        "residuals": {
            name: {"seen": test.seen, "reference": test.mean, "high": test.high, "low": test.low}
            for name, test in zip(NAMES, state.tests, strict=True)
        },
    }
