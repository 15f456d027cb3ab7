"""Where a study leaves its results: a directory of its own, in which nothing is overwritten."""

from pathlib import Path


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
