"""Judges by a sample what has too many mutants to try all: the groups of sampled.yaml.

Of each group it draws mutants, all with the same chance, and runs the tests against each, as run.py does, but
for those that survivors.yaml explains. The same seed draws the same.

    python sample.py GENERATOR COPY --sample N [--seed SEED] [GROUP...]
"""

from __future__ import annotations

import argparse
import random
import sys
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import run
import yaml

LEAST = 0.9  # share of the drawn that tests must notice
NORMAL = 1.96  # standard deviations on either side hold 95 %
Rooms = dict[str, list[str]]  # a module, or a folder of modules, below src/: tests below test/


class Row(NamedTuple):
    """A line of the table."""

    group: str
    seed: int
    mutants: int
    drawn: int
    explained: int  # of the drawn
    caught: int

    @property
    def share(self) -> float:
        """What the tests notice of the drawn that can be told from the code."""
        return self.caught / (self.drawn - self.explained)

    def interval(self) -> tuple[float, float]:
        """Return what the share may be in all mutants, with 95 % (Wilson's score)."""
        n, share, z = self.drawn - self.explained, self.share, NORMAL
        middle, width = share + z * z / (2 * n), z * ((share * (1 - share) + z * z / (4 * n)) / n) ** 0.5
        return (middle - width) / (1 + z * z / n), (middle + width) / (1 + z * z / n)


def modules(root: Path, rooms: Rooms) -> dict[Path, run.Tests]:
    """Return a group's modules with their tests; one without tests is not broken."""
    folders = {p: t for room, t in rooms.items() for p in (root / "src" / room).glob("*.py")}
    alone = {root / "src" / room: t for room, t in rooms.items() if room.endswith(".py")}
    return {p: tuple(f"test/{test}" for test in tests) for p, tests in (folders | alone).items() if tests}


def drawn(mutants: list[run.Mutant], count: int, seed: str) -> list[run.Mutant]:
    """Return so many of the mutants, or all, whatever order they came in."""
    ordered = sorted(mutants, key=lambda m: (m["source"], m["function"], m["key"]))
    return random.Random(seed).sample(ordered, min(count, len(ordered)))


def main(arguments: list[str]) -> int:
    """Print the survivors and the table; return 1 if a group's tests notice too little."""
    groups: dict[str, Rooms] = yaml.safe_load((run.HERE / "sampled.yaml").read_text("utf-8"))
    options = _options(arguments, [*groups])
    root, reasons = run.prepared(options.copy)
    tests, sizes, sample = dict[Path, run.Tests](), dict[str, int](), list[run.Mutant]()
    for group in options.groups or groups:
        tests |= (own := modules(root, groups[group]))
        mutants = run.made(options.generator, *own)
        sizes[group] = len(mutants)
        for mutant in drawn(mutants, options.sample, f"{options.seed} {group}"):
            why = reasons.get(str(Path(mutant["source"]).relative_to(root / "src")), {})
            sample.append({**mutant, "group": group, "explained": run.is_explained(mutant, why)})
    tried, left = [mutant for mutant in sample if not mutant["explained"]], list[run.Mutant]()
    # From below: what is imported once must not be broken later.
    for source in sorted({Path(m["source"]) for m in tried}, key=lambda path: (-_layer(root, path), path)):
        mine = [mutant for mutant in tried if Path(mutant["source"]) == source]
        left += run.survivors(source, mine, tests[source], root / "log")
    of = [Counter(mutant["group"] for mutant in some) for some in (sample, tried, left)]
    counts = {group: [count[group] for count in of] for group in sizes}
    rows = [
        Row(g, options.seed, sizes[g], n, n - judged, judged - lost)
        for g, (n, judged, lost) in counts.items()
    ]
    print(table(rows))
    return int(any(row.share < LEAST for row in rows))


def _layer(root: Path, source: Path) -> int:
    return run.layer(source.relative_to(root / "src").parts[0])


def _options(arguments: list[str], groups: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="scripts/mutate.sh", usage="%(prog)s --sample N [--seed SEED] [GROUP...]"
    )
    parser.add_argument("generator", help=argparse.SUPPRESS)
    parser.add_argument("copy", help=argparse.SUPPRESS)
    parser.add_argument("--sample", type=int, required=True, metavar="N", help="mutants of each group")
    parser.add_argument("--seed", type=int, default=1, help="draws other mutants (default: %(default)s)")
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=f"{', '.join(groups)} (default: all)")
    options = parser.parse_intermixed_args(arguments)
    if unknown := set(options.groups) - set(groups):
        parser.error(f"unknown group {', '.join(sorted(unknown))}; allowed: {', '.join(groups)}")
    return options


def table(rows: list[Row]) -> str:
    """Return the rows as Markdown."""
    lines = ["| group | seed | mutants | drawn | explained | caught | share, with 95 % |", "|" + "---|" * 7]
    for row in rows:
        low, high = row.interval()
        lines.append(f"| {' | '.join(map(str, row))} | {row.share:.0%} ({low:.0%} to {high:.0%}) |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
