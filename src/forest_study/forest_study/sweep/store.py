"""A study's rows: in the journal as batches end, in one Parquet file once all have.

DIR/study.yaml     the file
DIR/runs.jsonl     study, versions, files of machines, operators and paths; then the rows of each batch
DIR/runs.parquet   all rows, by number, with the first line above in its metadata
"""

import json
from collections.abc import Sequence
from pathlib import Path

from forest_description.config.source_tree import texts
from forest_study.journal import Journal
from forest_study.log_work.person import read_person
from forest_study.results import StudyError
from forest_study.sweep.design import combinations
from forest_study.sweep.study import Study
from forest_study.sweep.workers import Row
from forest_study.tracking.paths import NAMES as PATHS


class Store:
    """Where a study's rows go.

    Args:
        out: a new directory, an empty one, or that of the same study.
        study: whose rows they are.

    Raises:
        StudyError: pyarrow is not installed, or another study, or other versions, have begun there.
    """

    def __init__(self, out: Path, study: Study) -> None:
        _require_pyarrow()
        self.whole, self._study = out / "runs.parquet", study
        named = {"machines": _machines(study), "operators": _operators(study), "paths": _paths(study)}
        self._journal = Journal(out, {"study": study.text, **named})
        (out / "study.yaml").write_text(study.text, encoding="utf-8")

    def done(self) -> set[int]:
        """Return the numbers of the runs whose rows are there."""
        return {row["number"] for batch in self._journal.entries for row in batch}

    def add(self, rows: Sequence[Row]) -> None:
        """Write a batch's rows.

        Raises:
            OSError: the disk is full.
        """
        self._journal.add(list(rows))

    def finish(self) -> list[Row]:
        """Make one file of all rows; return them by number, with None where a failed run has no figure."""
        import pyarrow
        from pyarrow import parquet

        rows = sorted(
            (row for batch in self._journal.entries for row in batch), key=lambda row: row["number"]
        )
        names = dict.fromkeys(name for row in rows for name in row)
        whole = [{name: row.get(name) for name in names} for row in rows]
        about = {"study": self._study.text, "made_by": json.dumps(self._journal.made_by)}
        unfinished = self.whole.with_suffix(".unfinished")
        parquet.write_table(pyarrow.Table.from_pylist(whole).replace_schema_metadata(about), unfinished)
        unfinished.rename(self.whole)
        return whole


def _require_pyarrow() -> None:
    try:
        import pyarrow  # noqa: F401  the others import it where they use it: it takes a third of a second
    except ImportError:
        raise StudyError(
            "sweep needs pyarrow, which is not installed: pip install 'forest-crane[sweep]'"
        ) from None


def _machines(study: Study) -> dict[str, list[list[str]]]:
    """Return label and text of the files of each machine that a study names."""
    cases = [{**study.common, **combination} for combination in combinations(study)]
    names = {case[key] for case in cases for key in ("machine", "model") if case.get(key)}
    return {name: [list(one) for one in texts(name)] for name in sorted(names or {"c180"})}


def _operators(study: Study) -> dict[str, dict[str, float]]:
    """Return the numbers of each operator that a study names."""
    cases = [{**study.common, **combination} for combination in combinations(study)]
    names = {case["operator"] for case in cases if "operator" in case}
    return {name: dict(read_person(name)._asdict()) for name in sorted(names)}


def _paths(study: Study) -> dict[str, str]:
    """Return the text of each file of waypoints that a study names."""
    cases = [{**study.common, **combination} for combination in combinations(study)]
    names = {case["path"] for case in cases if "path" in case}.difference(PATHS)
    return {name: Path(name).read_text("utf-8") for name in sorted(names)}
