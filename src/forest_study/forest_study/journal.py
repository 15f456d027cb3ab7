"""Runs on disk as they are made, so that a command that was stopped goes on with those that are missing.

DIR/runs.jsonl      first what made them, then a line for each entry

While a journal lives no other command may write there: it would make the same runs a second time.
"""

import fcntl
import json
import os
import weakref
from pathlib import Path
from typing import Any

from forest_bag.record.run_context import versions
from forest_study.results import StudyError, new_directory


class Journal:
    """The entries of one command's runs.

    Args:
        out: a new directory, an empty one, or that of the same runs.
        made_by: what must be the same for runs to be the same, by name; the versions are added.

    Raises:
        StudyError: something else has begun there, or another command makes runs there.
    """

    def __init__(self, out: Path, made_by: dict[str, Any]) -> None:
        self._file, self.made_by = out / "runs.jsonl", made_by | {"versions": versions()}
        if not self._file.exists():
            new_directory(out)
            unfinished = out / "runs.jsonl.unfinished"
            unfinished.write_text(json.dumps(self.made_by) + "\n", encoding="utf-8")
            unfinished.rename(self._file)
        self._lock()
        lines = self._file.read_bytes().splitlines(keepends=True)
        if lines and not lines[-1].endswith(b"\n"):  # the computer went down in mid-line
            lines.pop()
            with self._file.open("r+b") as file:
                file.truncate(sum(map(len, lines)))
        try:
            begun, *self.entries = map(json.loads, lines)
            _ = begun["versions"].items()
        except (ValueError, TypeError, KeyError, AttributeError):  # nothing, or not ours
            raise StudyError(f"{self._file} holds no runs; allowed: another --out") from None
        changed = _changed(begun, json.loads(json.dumps(self.made_by)))
        if changed:
            raise StudyError(f"{out} was begun with other {', '.join(changed)}; allowed: another --out")

    def _lock(self) -> None:
        """Take the file, until this journal or its process is gone."""
        held = os.open(self._file, os.O_RDWR)
        weakref.finalize(self, os.close, held)
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            where = self._file.parent
            raise StudyError(f"{where}: another command makes runs there; allowed: another --out") from None

    def add(self, entry: Any) -> None:
        """Write an entry, of what JSON can say.

        Raises:
            OSError: the disk is full.
        """
        with self._file.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")
        self.entries.append(entry)


def _changed(begun: dict[str, Any], made_by: dict[str, Any]) -> list[str]:
    """Return what differs; of versions, which."""
    changed = [key for key, value in made_by.items() if key != "versions" and begun.get(key) != value]
    one, other = begun["versions"], made_by["versions"]
    return changed + sorted(key for key in one | other if one.get(key) != other.get(key))
