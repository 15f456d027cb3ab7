"""`forest-ident validate`: a held-out record against what a model predicts of it."""

import argparse
import json
from pathlib import Path

from forest_description.machine import load_machine
from forest_ident.measurements import session_bag
from forest_ident.measurements.session import SessionError
from forest_ident.refinement import experiment_check
from forest_ident.validation import prediction_error
from forest_ident.validation.verdict import NOT_TRUSTED, TRUSTED
from forest_msgs_py.runtime.command_line import Subcommands, subcommand


def add_parser(verbs: Subcommands) -> None:
    """Name the verb's flags."""
    text = "compare a held-out bag with what a machine file predicts"
    parser = subcommand(verbs, "validate", text, run)
    parser.add_argument("bag", type=Path, metavar="BAG", help="held-out bag")
    parser.add_argument("--model", required=True, metavar="NAME|FILE", help="machine file of the prediction")
    parser.add_argument(
        "--report", type=Path, metavar="DIR", help="directory to be made, with validation.html and .json"
    )


def run(options: argparse.Namespace) -> int:
    """Run the verb; return its exit code.

    Raises:
        SessionError: the bag cannot be predicted, is another machine's, or the report's directory is there.
    """
    if options.report is not None and options.report.exists():
        raise SessionError(f"{options.report} exists already; choose another --report or remove it")
    model = load_machine(options.model)
    session = session_bag.read(options.bag)
    experiment_check.demand_machine(model, session)
    found = prediction_error.signals(model, session)
    missed = prediction_error.over_limit(found)
    code = NOT_TRUSTED if missed else TRUSTED
    if missed:
        print(f"verdict: {model.name} does not predict {options.bag}: {'; '.join(missed)}")
    else:
        print(f"verdict: {model.name} predicts {options.bag}")
    print(prediction_error.text_table(found))
    if options.report is None:
        return code
    from forest_ident.report.validation_report import write  # matplotlib takes half a second

    page = write(session, model, found, options.report)
    scores = {
        f"{s.axis} {s.name}": {"nrmse": s.nrmse, "limit": prediction_error.limit(s), "vaf": s.vaf}
        for s in found
    }
    file = options.report / "validation.json"
    text = json.dumps({"model": model.name, "record": session.name, "signals": scores}, indent=2)
    file.write_text(text + "\n", encoding="utf-8")
    print(f"  {page}\n  {file}")
    return code
