"""A study's figures on disk: a part for each batch as it ends, one Parquet file once all have.

    DIR/study.yaml     the file
    DIR/made_by.json   versions, and the machines' files
    DIR/parts/*.parquet
    DIR/runs.parquet   all parts, by number, with the two above in its metadata

A part gets its name when it is whole. What was stopped goes on with the runs that no part holds.
"""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from forest_bag.record.run_context import versions
from forest_description.config.source_tree import texts
from forest_study.log_work.person import read_person
from forest_study.results import StudyError, new_directory, write_json
from forest_study.sweep.design import combinations
from forest_study.sweep.study import Study
from forest_study.sweep.workers import Row


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
        self._out, self._parts = out, out / "parts"
        self.whole = out / "runs.parquet"
        self._made_by: dict[str, Any] = {
            "versions": versions(),
            "machines": _machines(study),
            "operators": _operators(study),
        }
        if (out / "study.yaml").exists():
            self._require_same(study)
        else:
            new_directory(out)
            write_json(out / "made_by.json", self._made_by)
            (out / "study.yaml").write_text(study.text, encoding="utf-8")
        self._parts.mkdir(exist_ok=True)

    def _require_same(self, study: Study) -> None:
        begun = json.loads((self._out / "made_by.json").read_text("utf-8"))
        if (self._out / "study.yaml").read_text("utf-8") != study.text:
            raise StudyError(
                f"{self._out} holds another study; allowed: another --out, or its own study.yaml"
            )
        if begun != self._made_by:
            changed = [key for key in begun["versions"] if begun["versions"][key] != versions().get(key)]
            what = ", ".join(changed) or "a machine's or operator's file"
            raise StudyError(f"{self._out} was begun with another {what}; allowed: another --out")

    def done(self) -> set[int]:
        """Return the numbers of the runs whose rows are there."""
        from pyarrow import parquet

        files = [self.whole] if self.whole.exists() else sorted(self._parts.glob("*.parquet"))
        tables = [parquet.read_table(file, columns=["number"]) for file in files]
        return {number for table in tables for number in table["number"].to_pylist()}

    def add(self, rows: Sequence[Row]) -> None:
        """Write a batch's rows.

        Raises:
            OSError: the disk is full.
        """
        import pyarrow
        from pyarrow import parquet

        name = f"{min(row['number'] for row in rows):09}.parquet"
        unfinished = self._parts / f"{name}.unfinished"
        parquet.write_table(pyarrow.Table.from_pylist(list(rows)), unfinished)
        unfinished.rename(self._parts / name)

    def finish(self) -> list[Row]:
        """Make one file of all parts; return its rows, in the order of their numbers."""
        import pyarrow
        from pyarrow import parquet

        if not self.whole.exists():
            parts = [parquet.read_table(file) for file in sorted(self._parts.glob("*.parquet"))]
            table = pyarrow.concat_tables(parts, promote_options="permissive").sort_by("number")
            about = {
                "study": (self._out / "study.yaml").read_text("utf-8"),
                "made_by": json.dumps(self._made_by),
            }
            unfinished = self._out / "runs.parquet.unfinished"
            parquet.write_table(table.replace_schema_metadata(about), unfinished)
            unfinished.rename(self.whole)
        for file in self._parts.glob("*.parquet"):
            file.unlink()
        found: list[Row] = parquet.read_table(self.whole).to_pylist()
        return found


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
