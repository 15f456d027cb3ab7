"""`forest-study thesis`: the thesis' evaluation of its schemes, on its own joints or on the full machine."""

import argparse

from forest_study.results import new_directory


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Give the verb its arguments."""
    parser.add_argument(
        "--plant",
        choices=("linear", "machine"),
        default="linear",
        help="linear joints as in the thesis, or the full machine (default: %(default)s)",
    )


def run(options: argparse.Namespace) -> int:
    """Write numbers and pictures, print the tables; return the exit code.

    Raises:
        StudyError: the directory is not empty.
    """
    new_directory(options.out)
    if options.plant == "machine":
        from forest_study.thesis import thesis_machine_report

        return thesis_machine_report.report(options.out)
    from forest_study.thesis import thesis_report

    return thesis_report.report(options.out)
