"""Where a study leaves its results: a directory of its own, in which nothing is overwritten."""

import json
from pathlib import Path
from typing import Any


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


def write_json(path: Path, report: dict[str, Any]) -> None:
    """Write numbers as people and programs read them."""
    path.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
