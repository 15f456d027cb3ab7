"""Runs of the matrix by gains, each done once: an entry of the journal for each point and block of seeds."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from forest_control.config.controller_settings import Settings
from forest_description.config.source_tree import texts
from forest_description.machine import Machine, load_machine
from forest_study.journal import Journal
from forest_study.matrix.matrix_rows import MatrixRow
from forest_study.matrix.matrix_runs import run_row
from forest_study.matrix.rivals import Rival
from forest_study.tune.gains import gains_of

Row = dict[str, Any]  # of a seed: its figures by name, None where a run did not end; "seed", "row"


class Bench:
    """The matrix' plants, and what was reached on them.

    Args:
        out: a new directory, an empty one, or that of the same search.
        machine: name or file, what controller and driver believe.
        rows: of the matrix.

    Raises:
        StudyError: another search, or another version, has begun there.
        MachineError: the machine cannot be read.
    """

    def __init__(self, out: Path, machine: str, rows: Sequence[MatrixRow]) -> None:
        self.machine: Machine = load_machine(machine)
        self._rows = rows
        files = [list(one) for one in texts(machine)]
        self._journal = Journal(out, {"machine": files, "rows": [row.name for row in rows]})
        self._kept: dict[str, list[Row]] = {one["key"]: one["rows"] for one in self._journal.entries}

    def run(self, settings: Settings, seeds: range) -> list[Row]:
        """Return what gains reach: a row for each of the matrix' rows and each seed within the capacity.

        Raises:
            PathError: a path leaves the machine's reach.
            MachineError: the machine lacks what is drawn.
        """
        key = _key(settings, seeds)
        if key not in self._kept:
            rows = [
                {"row": row.name, "seed": one.seed, "figures": one.figures and one.figures._asdict()}
                for row in self._rows
                for one in run_row(row, self.machine, seeds, rival=Rival(settings))
                if not one.overloaded
            ]
            self._journal.add({"key": key, "rows": rows})
            self._kept[key] = rows
        return self._kept[key]


def _key(settings: Settings, seeds: range) -> str:
    return json.dumps([gains_of(settings), seeds.start, seeds.stop])
