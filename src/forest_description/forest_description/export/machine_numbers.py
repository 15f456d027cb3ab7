"""docs/reference/machine.md: every number of the shipped machines and where it comes from."""

from forest_description.config.parameter import Parameter, ParameterSet, choice_of, fields_of, parameter_of
from forest_description.config.schema import Quantity
from forest_description.machine import Machine, load_machine, sources

INTRODUCTION = """# The machine in numbers

Made by `python -m forest_description.export.machine_numbers` from the files in
`forest_description/machines/`. Do not edit it by hand.
A number is from the **thesis** (with its place) or **assumed** (with the reason).

- `c180_thesis` is the crane with the choices of the thesis, a known slip included.
- `c180_hoses` is based on it: the slip corrected, and with what a teleoperated machine needs. Its
  oil yields in the hoses only.
- `c180`, the default, is the crane as it would be built: `c180_hoses` with what the thesis leaves
  out.
- `loader` is a machine of another class, a small trailer loader crane. All of it is assumed.
  It shows what a machine file can say: load-sensing pump, valves by axis and direction, friction,
  hanging head.
- `forwarder` is the crane of a forwarder of 15 t as they are built today. All of it is assumed:
  load sensing with flow sharing, counterbalance valves, a grapple that hangs.
"""


def origin(source: str) -> str:
    """Return the kind of a source: "thesis", "assumed", or "other" (a data sheet, a measurement)."""
    for kind in ("thesis", "assumed"):
        if source.lower().startswith(kind):
            return kind
    return "other"


def declared(part: ParameterSet) -> dict[str, Parameter]:
    """Return the parameters that a machine, or a part of one, declares, by dotted key."""
    found = {key: parameter_of(field) for key, field, _ in fields_of(part)}
    return {key: allowed for key, allowed in found.items() if allowed is not None}


def choices(part: ParameterSet) -> dict[str, str]:
    """Return what a machine, or a part of one, chooses, by dotted key; "none" for what it has not."""
    found: dict[str, str] = {}
    for key, field, value in fields_of(part):
        if value is None:
            found[key] = "none"
        elif choice_of(field) is not None:
            found[key] = str(value)
        elif hasattr(value, "kind"):
            found[key] = str(value.kind)
    return found


def choice_table(chosen: dict[str, str]) -> str:
    """Return Markdown for some choices, one line each."""
    lines = ["| key | choice |", "|---|---|", *(f"| `{key}` | {word} |" for key, word in chosen.items())]
    return "\n".join(lines)


def number(value: float | tuple[float, ...], digits: int) -> str:
    """Return a number, or a row of them, as text."""
    return ", ".join(f"{item:.{digits}g}" for item in (value if isinstance(value, tuple) else (value,)))


def table(rows: list[Quantity], machine: Machine) -> str:
    """Return Markdown for some numbers of a machine: key, value, unit, meaning, origin, source."""
    meanings = declared(machine)
    lines = ["| key | value | unit | meaning | from | source |", "|---|---|---|---|---|---|"]
    for row in rows:
        reason = row.source.removeprefix("assumed: ")
        cells = [
            f"`{row.key}`",
            number(row.value, 10),
            row.unit,
            meanings[row.key].doc,
            origin(row.source),
            reason,
        ]
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def document() -> str:
    """Return the whole docs/reference/machine.md."""
    thesis, hoses, built = (load_machine(name) for name in ("c180_thesis", "c180_hoses", "c180"))
    printed, chosen = sources("c180_thesis"), choices(thesis)
    numbers, others = _what_differs("c180_hoses", "c180_thesis")
    further, more = _what_differs("c180", "c180_hoses")
    return (
        f"{INTRODUCTION}\n## c180_thesis\n\n{choice_table(chosen)}\n\n{table(printed, thesis)}\n\n"
        f"## c180_hoses: what differs\n\n{choice_table(others)}\n\n{table(numbers, hoses)}\n\n"
        f"## c180: what differs from c180_hoses\n\n{choice_table(more)}\n\n{table(further, built)}\n\n"
        f"{_whole('loader')}\n{_whole('forwarder')}"
    )


def _whole(name: str) -> str:
    """Return a chapter with all that a shipped machine says."""
    machine = load_machine(name)
    return f"## {name}\n\n{choice_table(choices(machine))}\n\n{table(sources(name), machine)}\n"


def _what_differs(name: str, base: str) -> tuple[list[Quantity], dict[str, str]]:
    """Return numbers and choices of a shipped machine that another one does not have."""
    told, chosen = sources(base), choices(load_machine(base))
    numbers = [row for row in sources(name) if row not in told]
    return numbers, {k: word for k, word in choices(load_machine(name)).items() if chosen.get(k) != word}


def main() -> None:
    """Print the document."""
    print(document(), end="")


if __name__ == "__main__":
    main()
