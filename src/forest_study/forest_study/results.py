"""Where a study leaves its results: a directory of its own, in which nothing is overwritten."""

import json
from pathlib import Path
from typing import Any

from forest_compile.kernel_cache import can_compile
from forest_msgs_py.runtime.command_line import path_in_errors


class StudyError(Exception):
    """A study cannot be made; the message is one sentence for the user."""


def new_directory(out: Path) -> None:
    """Make the directory for results, or take an empty one.

    Raises:
        StudyError: something is in it: results are never overwritten.
        OSError: it cannot be made, or is a file.
    """
    out.mkdir(parents=True, exist_ok=True)
    if any(out.iterdir()):
        raise StudyError(f"{out} is not empty; choose another --out or remove it")


def require_llvm(study: str, extra: str = "fast") -> None:
    """Refuse a study that would take days without machine code.

    Args:
        study: the subcommand.
        extra: of this project's packages, that brings LLVM and what else the study needs.

    Raises:
        StudyError: LLVM is not installed.
    """
    if not can_compile():
        raise StudyError(f"{study} needs LLVM, which is not installed: pip install 'forest-crane[{extra}]'")


def write_json(path: Path, report: dict[str, Any]) -> None:
    """Write numbers as people and programs read them."""
    with path_in_errors(path):
        path.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
