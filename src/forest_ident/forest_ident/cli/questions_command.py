"""`forest-ident questions`: what the thesis' validation leaves open, asked of simulated machines."""

import argparse
import json
from pathlib import Path

from forest_description.machine import load_machine
from forest_ident.measurements.session import SessionError
from forest_ident.validation import unmodelled_effects
from forest_msgs_py.runtime.command_line import Subcommands, add_machine_option, subcommand, whole


def add_parser(verbs: Subcommands) -> None:
    """Name the verb's flags."""
    text = "find the causes of a missed return pressure and of an unmodelled pendulum, on simulated machines"
    parser = subcommand(verbs, "questions", text, run)
    add_machine_option(parser, "c180_hoses")
    parser.add_argument(
        "--seed",
        type=whole(0),
        default=0,
        metavar="N",
        help="seed of sensor noise and drawn values (default: 0)",
    )
    parser.add_argument("--exact", action="store_true", help="exact sensors instead of Table 4.2's")
    parser.add_argument(
        "--out",
        type=Path,
        required=True,
        metavar="DIR",
        help="directory to be made, with questions.json and .png",
    )


def run(options: argparse.Namespace) -> int:
    """Run the verb; return its exit code.

    Raises:
        SessionError: the directory is there, or the machine lacks the sensors.
    """
    machine = load_machine(options.machine)
    if options.out.exists():
        raise SessionError(f"{options.out} exists already; choose another --out or remove it")
    answers = [
        unmodelled_effects.answer(case, options.seed, not options.exact)
        for case in unmodelled_effects.cases(machine)
    ]
    for answer in answers:
        print(text_table(answer), end="\n\n")
    from forest_ident.report.validation_report import (
        draw_unmodelled_effects,  # matplotlib takes half a second
    )

    options.out.mkdir(parents=True)
    cases = {
        answer.case.name: [s._asdict() | {"nrmse": s.nrmse} for s in answer.scores] for answer in answers
    }
    text = json.dumps({"machine": machine.name, "seed": options.seed, "cases": cases}, indent=2)
    (options.out / "questions.json").write_text(text + "\n", encoding="utf-8")
    draw_unmodelled_effects(answers, options.out / "questions.png")
    print(f"  {options.out / 'questions.json'}\n  {options.out / 'questions.png'}")
    return 0


def text_table(answer: unmodelled_effects.Answer) -> str:
    """Return a case's NRMSE per axis [%]; pressures while the valve is open."""
    names = ("angle", "velocity", "flow", "driving", "return")
    head = [answer.case.name, *names, *(f"{name} {way}" for name in names[3:] for way in ("out", "in"))]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for axis in dict.fromkeys(s.axis for s in answer.scores):
        of = {(s.signal, s.way): 100.0 * s.nrmse for s in answer.scores if s.axis == axis}
        keys = [(name, "both") for name in names]
        keys += [(name, way) for name in names[3:] for way in ("out", "in")]
        cells = (f"{of[key]:.2f}" if key in of else "-" for key in keys)
        lines.append(f"| {axis} | " + " | ".join(cells) + " |")
    return "\n".join(lines)
