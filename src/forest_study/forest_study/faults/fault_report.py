"""The table of faults: what was done, what must happen, what happened at worst; and what breaks a bound."""

import math
import re
from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any

from forest_study.faults.fault import Bound, Fault, State
from forest_study.faults.trials import Outcome

PAGE = """# Faults

What was done to the crane, what must happen, and what happened at worst. `scripts/faults.sh` makes
this page in an hour; its exit code 1 tells that a bound is broken.

{machine}, {seeds} seeds a cell, {cells} cells. The real controller, joystick watch and valve driver
drive the simulated machine in the closed loop. Each seed draws place, wish, sensor noise, the axis
that is hit, and the moment.

- A fault lasts two seconds and heals, unless its row says otherwise.
- The operator goes on as before. Nothing may move again before a deliberate act: deadman released,
  levers centred, deadman pressed. A run that moved again breaks its bound, whatever the row asks,
  unless it asks "may be held again".
- After that act the healed crane must move.

| column | tells |
|---|---|
| must: zero | time to zero voltage at the valves |
| must: way | of the tip, from the fault until half a second after that |
| must: off | distance of the tip from the same run without the fault |
| a state | the worst of all seeds, of what the row bounds; **bold** is beyond; empty cannot differ |
| told | what `/diagnostics` says first, most often |

Rows that ask only how far the tip is off, or how fast it is, or nothing, are faults that need no
stop, or that nobody sees. The latter are gaps: the [reasons](#reasons) say which.

{table}

What only processes can show is [below](#live). Browsers that go away, devices that are unplugged and
broken bags have tests of their own: [safety](safety.md). No test sets the computer's clock: stamps
that jump stand above, and ages are of clocks that nobody sets.

## Reasons

{reasons}
"""
Found = Mapping[str, Any]  # of a cell, as `worst` tells it
Cells = Mapping[tuple[str, State], Found]
STATES = tuple(State)
NUMBER = re.compile(r"-?\d+\.\d+")


def broken(bound: Bound, outcome: Outcome) -> list[str]:
    """Return what a seed breaks of a bound, in sentences."""
    found = []
    if outcome.restarted and not bound.held:
        found.append("it moved again without a deliberate act")
    if bound.zero is not None and outcome.zero > bound.zero:
        found.append(f"zero voltage after {outcome.zero:.2f} s; allowed: {bound.zero:g} s")
    for name, allowed in (("way", bound.way), ("off", bound.off), ("speed", bound.speed)):
        value = getattr(outcome, name)
        if allowed is not None and value > allowed:
            found.append(f"{name} is {value:.3f}; allowed: {allowed:g}")
    if bound.told and not outcome.told.startswith(bound.told):
        found.append(f"the operator is told {outcome.told!r}; wanted: {bound.told!r}")
    if bound.told and outcome.told_after > bound.told_within:
        found.append(f"told after {outcome.told_after:.2f} s; allowed: {bound.told_within:g} s")
    if bound.again and not outcome.again:
        found.append("it did not move after the deliberate act")
    return found


def worst(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Return the worst of each figure, and every sentence that was told."""
    return {
        "zero_s": max(one.zero for one in outcomes),
        "way_m": max(one.way for one in outcomes),
        "off_m": max(one.off for one in outcomes),
        "speed_m_s": max(one.speed for one in outcomes),
        "told_after_s": max(one.told_after for one in outcomes),
        "restarted": sum(one.restarted for one in outcomes),
        "told": sorted({NUMBER.sub("…", one.told) for one in outcomes}),
        "seeds": [one.seed for one in outcomes],
    }


def table(faults: Mapping[str, Fault], cells: Cells) -> str:
    """Return the table in Markdown, a row for each fault."""
    head = ["fault", "what is done", "must", *(state.value for state in STATES), "told"]
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    for name, fault in faults.items():
        shown = [
            _cell(fault.bounds[state], cells[name, state]) if (name, state) in cells else ""
            for state in STATES
        ]
        if any(shown):
            row = [name, fault.text, _must(fault), *shown, _told(name, cells)]
            lines.append(f"| {' | '.join(row)} |")
    return "\n".join(lines)


def page(machine: str, seeds: int, faults: Mapping[str, Fault], cells: Cells) -> str:
    """Return the page of the documentation."""
    return PAGE.format(
        machine=f"`{machine}`",
        seeds=seeds,
        cells=len(cells),
        table=table(faults, cells),
        reasons=reasons(faults),
    )


def reasons(faults: Mapping[str, Fault]) -> str:
    """Return why each fault has its bound, as a list in Markdown."""
    told = (f"- **{name}**: {fault.reason}" for name, fault in faults.items())
    return "\n".join(fill(text, 100, subsequent_indent="  ", break_on_hyphens=False) for text in told)


def _must(fault: Fault) -> str:
    asked: dict[str, list[str]] = {}
    for state, bound in fault.bounds.items():
        asked.setdefault(_asked(bound), []).append(state.value)
    common = max(asked, key=lambda text: len(asked[text]))
    others = [f"{', '.join(states)}: {text}" for text, states in asked.items() if text != common]
    return "; ".join([common, *others])


def _asked(bound: Bound) -> str:
    parts = []
    if bound.zero is not None:
        parts.append(f"zero in {bound.zero:g} s")
    if bound.way is not None:
        parts.append(f"way {bound.way:g} m")
    if bound.off is not None:
        parts.append(f"off {bound.off:g} m")
    if bound.speed is not None:
        parts.append(f"{bound.speed:g} m/s")
    if bound.held:
        parts.append("may be held again")
    return ", ".join(parts) or "nothing is asked"


def _cell(bound: Bound, found: Found) -> str:
    """Return a cell: the worst of what is bounded."""
    beyond = found["restarted"] > 0 and not bound.held
    parts = []
    for key, allowed, text in (
        ("zero_s", bound.zero, "{:.2f} s"),
        ("way_m", bound.way, "{:.3f} m"),
        ("off_m", bound.off, "off {:.3f} m"),
        ("speed_m_s", bound.speed, "{:.2f} m/s"),
    ):
        if allowed is not None:
            value = found[key]
            beyond = beyond or value > allowed
            parts.append("moves on" if math.isinf(value) else text.format(value))
    shown = ", ".join(parts) or "moves on"
    return f"**{shown}**" if beyond else shown


def _told(name: str, cells: Cells) -> str:
    """Return the sentences that were told, the numbers left out; most states share one."""
    said = [text for (fault, _), found in cells.items() if fault == name for text in found["told"]]
    named = [text for text in said if text]
    if not named:
        return "nothing"
    first = max(sorted(set(named)), key=named.count)
    return f"{first}{'' if len(named) == len(said) else '; or nothing'}".replace("|", "/")
