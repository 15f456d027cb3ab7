"""docs/reference/machine-file.md: what a machine file may say, made from the dataclasses that read it."""

import dataclasses
import textwrap

from forest_description.config.schema import FieldKind, field_kinds
from forest_description.config.units import units_for
from forest_description.machine import Machine

INTRODUCTION = """# Machine files

Made by `python -m forest_description.export.machine_keys` from the code that reads the files.
Do not edit it by hand. The shipped machines' numbers are in [the machine in numbers](machine.md),
the way to a file of your own in [another machine file](../how-to/another-machine.md).

A machine is a YAML file. Each number has its unit and its source, and so has each row of numbers:

```yaml
based_on: c180            # optional: a shipped machine or another file; then only what differs is given
name: my_crane            # optional: the file's name without suffix
description: A crane with smaller hoses and an underlapped swing valve
swing:
  valve:                  # an axis' own valve: what differs from the one that all share
    deadband_voltage: {value: -0.2, unit: V, source: "measured"}
hose:
  kind: measured          # a component of several sorts says which
  length: {value: 160, unit: in, source: "measured"}
manipulator:
  log: null               # an optional component that is not there
```

- Without `based_on` every key must be given. *Or null* marks the keys that may be `null`; *or left
  out* those that need not be there, which means the same.
- A section whose `kind` differs from the base's is given anew, with all its keys. A `pendulum`
  without `kind` is one body; with `kind: grapple` its parts are told.
- A number may state its `uncertainty`, half of its 95 % interval in its own unit. Identification
  counts it ([stated numbers](../explanation/identification.md#how-do-the-estimators-work)).
- A unit may be any of the quantity. Ranges are in SI and wide: they catch a slipped decimal point,
  not an unusual crane.
- A slip is answered with file, line, key and what is allowed: `forest-sim check my_crane.yaml`.
- A constant flow pump's relief valve opens at its `supply_pressure`.
- A curve of `kind: flow` has the flows that a data sheet prints over the voltage, all at one drop.
- A polynomial C_R must fall from `deadband_voltage` to `rated_voltage`. The first is negative if
  the valve is underlapped.

**Drawn machines.** `unknown:SEED` in place of a machine's name is drawn within 40 % of c180_hoses,
in all that [identification](../explanation/identification.md) finds. `unknown` is seed 0, and
`unknown:SEED:loader` is drawn from another machine. Equal seeds are one machine in every command.

Numbers that contradict each other are refused, too:

- moments and products of inertia that no rigid body has: I_zz above I_xx + I_yy, and so round;
  a plane body has I_zz = I_xx + I_yy. With `head_folding: thesis`, an I_xx of 0 means: not told
- inertia without mass; a stick that nothing resists
- `spool_damping` without `spool_bandwidth`; a rated voltage within the overlap; `hysteresis` that
  keeps the valve shut at its rated voltage
- a compensator on an underlapped valve, or one that uses more than the pump's margin; flow
  sharing without a load-sensing pump
- flow forces on a spool without lag, without oil, or that take half of its stroke
- leakage that follows an overlap, without overlap or without leakage
- load holding without `chambers`; a counterbalance valve whose hysteresis is above its setting; one
  that the pump's full pressure on the other side does not open
- a rod side larger than the head side; swapped limits; boom angles beyond ±180°
- a stroke that passes a dead point of the linkage, or is longer than the retracted cylinder
- a port relief below the pump's or the anti-cavitation pressure; a main relief below the pump's
- a pump that its own leakage or its engine keeps from its pressure; half a pump
- a compensator band above the pump's pressure or the load-sensing margin
- one of the swash plate's two times alone; a torque that does not even hold the pump's pressure
- an engine that stalls before it gives its greatest torque
- an open compensator that takes all of the pump's pressure at its full flow
- a tank line that takes all of the pump's pressure at its full flow
- friction whose `smoothing_speed` is above its `stribeck_speed`; seals that pressure alone would
  hold
- breaking away that is easier than sliding, or takes over 0.01 rad, or more than the motor has
- a gear whose play is wider than the swing's travel
- links that the crane's weight, or a column that the motor, would deflect by over 0.1 rad; links
  that are damped beyond swinging, or whose root is heavier than all that it carries
- a rotator as heavy as its head, or with its centre beyond its end; a log off a hanging head's axis
- a vehicle whose centre of mass lies beyond its wheels or legs
- a load chart that grows with the reach, or ends before the crane's own reach

What is possible and not wise, `forest-sim check` warns of.
"""


def document() -> str:
    """Return the whole docs/reference/machine-file.md."""
    places: dict[tuple[type, ...], list[str]] = {}
    _collect(Machine, "", places)
    whole = ["## The whole", "", *_table(Machine)]
    return "\n".join(
        [INTRODUCTION, *whole, *(line for kinds in places for line in _section(places[kinds], kinds))]
    )


def _collect(kind: type, prefix: str, places: dict[tuple[type, ...], list[str]]) -> None:
    """Note at which keys each component may stand, in the order of the fields."""
    for name, field in field_kinds(kind).items():
        if _is_section(field):
            places.setdefault(field.kinds, []).append(prefix + name)
            for sort in field.kinds:
                _collect(sort, f"{prefix}{name}.", places)


def _section(keys: list[str], kinds: tuple[type, ...]) -> list[str]:
    """Return the lines of a component, each of its sorts in a table of its own."""
    first, *others = dict.fromkeys(keys)
    title, lines = f"`{first}`", []
    for kind in kinds:
        lines += [f"## {title}{f', kind: {kind.kind}' if hasattr(kind, 'kind') else ''}", ""]
        if others:
            lines += ["The same keys:", "", *(f"- `{key}`" for key in others), ""]
        lines += _table(kind)
    return lines


def _table(kind: type) -> list[str]:
    """Return the lines that tell what a dataclass holds."""
    rows = [_row(name, field) for name, field in field_kinds(kind).items()]
    head = textwrap.fill((kind.__doc__ or "").split("\n", 1)[0], 100)
    return [head, "", "| key | unit | range | meaning |", "|---|---|---|---|", *rows, ""]


def _is_section(field: FieldKind) -> bool:
    return any(dataclasses.is_dataclass(kind) for kind in field.kinds)


def _row(name: str, field: FieldKind) -> str:
    """Return a key's line of the table."""
    null = " or null" if field.optional else ""
    null += " or left out" if field.may_be_left_out else ""
    if field.allowed is not None:
        unit = ", ".join(units_for(field.allowed.unit))
        row = "row of numbers, each " if field.row else ""
        return f"| `{name}` | {unit} | {row}{field.allowed.range}{null} | {field.allowed.doc} |"
    if field.choice is not None:
        return f"| `{name}` | | {', '.join(field.choice.words)}{null} | {field.choice.doc} |"
    if not _is_section(field):
        return f"| `{name}` | | a text{null} | |"
    sorts = [kind.kind for kind in field.kinds if hasattr(kind, "kind")]
    kind = f", kind: {', '.join(sorts)}" if sorts else ""
    return f"| `{name}` | | a section{kind}{null} | below |"


def main() -> None:
    """Print the document."""
    print(document(), end="")


if __name__ == "__main__":
    main()
