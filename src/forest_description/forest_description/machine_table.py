"""The table of every number of the shipped machines and its origin, as Markdown: docs/machine.md."""

from __future__ import annotations

from forest_description.machine import Machine, sources
from forest_description.machine_file import Quantity, parameters

INTRODUCTION = """# The machine in numbers

Made by `python -m forest_description.machine_table` from the files in `forest_description/machines/`; do not
edit by hand. A number is from the **thesis** (with its place) or **assumed** (with the reason).

- `c180_thesis` is the crane with the choices that the thesis prints, a known slip included.
- `c180`, the default, is based on it: the slip corrected, and with what a teleoperated machine needs.
"""


def origin(source: str) -> str:
    """Return the kind of a source: "thesis", "assumed", or "other" (a data sheet, a measurement)."""
    for kind in ("thesis", "assumed"):
        if source.lower().startswith(kind):
            return kind
    return "other"


def table(rows: list[Quantity]) -> str:
    """Return Markdown for some numbers, one line each: key, value, unit, meaning, origin, source."""
    declared = parameters(Machine)
    lines = ["| key | value | unit | meaning | from | source |", "|---|---|---|---|---|---|"]
    for row in rows:
        reason = row.source.removeprefix("assumed: ")
        cells = [
            f"`{row.key}`",
            f"{row.value:.10g}",
            row.unit,
            declared[row.key].doc,
            origin(row.source),
            reason,
        ]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def assumptions() -> str:
    """Return Markdown for the default machine's assumed numbers, one line each: key, value, unit, why."""
    lines = ["| assumed | value | why |", "|---|---|---|"]
    for row in sources("c180"):
        if origin(row.source) == "assumed":
            cells = (f"`{row.key}`", f"{row.value:.6g} {row.unit}", row.source.removeprefix("assumed: "))
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def document() -> str:
    """Return the whole docs/machine.md."""
    printed = sources("c180_thesis")
    differences = [row for row in sources("c180") if row not in printed]
    return (
        f"{INTRODUCTION}\n## c180_thesis\n\n{table(printed)}\n\n"
        "It has no port valves, no end stops and no spool lag.\n\n"
        f"## c180: what differs\n\n{table(differences)}\n"
    )


def main() -> None:
    """Print the document."""
    print(document(), end="")


if __name__ == "__main__":
    main()
