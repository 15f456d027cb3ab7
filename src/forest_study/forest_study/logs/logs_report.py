"""The page for people: what tip control would bring a crane, with pictures."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import ChoiceLoader, FileSystemLoader

from forest_description.machine import Machine
from forest_ident.report import html_page
from forest_study.log_work import person, trial
from forest_study.log_work.clearance import chain
from forest_study.log_work.site import Site, site_of
from forest_study.log_work.work import Work
from forest_study.logs.tables import SHOWN, Group, change, name, with_interval

PUBLISHED = {"loading": -5.2, "unloading": -7.9}  # [%] Silva Fennica 10161
COLOURS = {"joint": "tab:red", "tip": "tab:blue", "assisted": "tab:green", "taught": "tab:purple"}
PARTS = ("up", "across", "down", "grapple")


def write(
    file: Path, machine: Machine, operators: Sequence[str], persons: int, found: Sequence[Group], made: str
) -> Path:
    """Write the page; return its path.

    Args:
        file: to be written.
        machine: whose page it is.
        operators: as they were named.
        persons: of each.
        found: their figures.
        made: the command.
    """
    own = FileSystemLoader(Path(__file__).parent / "templates")
    page = html_page.ENVIRONMENT.overlay(loader=ChoiceLoader([own, html_page.LOADER]))
    site = site_of(machine)
    text = page.get_template("log_report.html").render(
        title=f"What would tip control bring {machine.name}?",
        machine=machine,
        persons=persons,
        made=made,
        answers=answers(found),
        images=_images(machine, site, operators[-1], found),
        groups=found,
        name=name,
        shown=SHOWN,
        with_interval=with_interval,
        operators=operators,
        numbers=_numbers(operators),
        site=site,
    )
    file.write_text(text, encoding="utf-8")
    return file


def answers(found: Sequence[Group]) -> list[str]:
    """Return a sentence for each operator and mode: what is shown, or that nothing is."""
    said = []
    for group in found:
        first = next(iter(group.modes))
        for mode, by in group.saved.items():
            d = by["time"]
            if not math.isfinite(d.low):
                verdict = "one person shows nothing"
            elif d.low > 0.0:
                verdict = "faster"
            elif d.high < 0.0:
                verdict = "slower"
            else:
                verdict = "no difference is shown"
            said.append(f"{name(group)}, {mode} against {first}: {verdict}; time {change(d)}.")
    return said


def _numbers(operators: Sequence[str]) -> list[tuple[Any, list[float], str]]:
    people = [person.read_person(one)._asdict() for one in operators]
    sources = [person.sources(one) for one in operators]
    return [
        (row, [one[key] for one in people], "; ".join(dict.fromkeys(s.get(key, "default") for s in sources)))
        for key, row in person.ROWS.items()
    ]


def _images(machine: Machine, site: Site, operator: str, found: Sequence[Group]) -> list[tuple[str, str]]:
    modes = list(found[0].modes)
    one = person.drawn(person.read_person(operator), 0)
    done = {mode: trial.work(machine, mode, one, 0.0, 0) for mode in modes}
    return [
        (html_page.image(_times(found)), "Time of the task by its parts, mean over persons."),
        (
            html_page.image(_changes(found)),
            "Change of time, 95 % intervals; dashed: published for real cranes.",
        ),
        (
            html_page.image(_paths(site, done)),
            f"The grip's ways of one person ({operator}), from above and from the side of the bunk.",
        ),
    ]


def _times(found: Sequence[Group]) -> Any:
    from matplotlib.figure import Figure  # half a second

    figure = Figure(figsize=(7.0, 0.6 + 0.45 * sum(len(g.modes) for g in found)), layout="constrained")
    axes = figure.subplots()
    rows = [
        (f"{name(g)}, {mode}", figures)
        for g in reversed(found)
        for mode, figures in reversed(g.modes.items())
    ]
    left = np.zeros(len(rows))
    for part in PARTS:
        lengths = np.array([figures[part].value for _, figures in rows])
        axes.barh(range(len(rows)), lengths, left=left, label=part)
        left = left + lengths
    axes.set_yticks(range(len(rows)), [label for label, _ in rows])
    axes.set_xlabel("s")
    figure.legend(ncols=4, fontsize="small", loc="outside upper center")
    return figure


def _changes(found: Sequence[Group]) -> Any:
    from matplotlib.figure import Figure

    rows = [(f"{name(g)}, {mode}", mode, by) for g in found for mode, by in g.saved.items()][::-1]
    figure = Figure(figsize=(7.0, 1.0 + 0.5 * len(rows)), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    for ax, part in zip(axes, PUBLISHED, strict=True):
        ax.axvline(0.0, color="black", linewidth=0.8)
        ax.axvline(PUBLISHED[part], color="grey", linestyle="--", linewidth=1.0)
        for k, (_, mode, by) in enumerate(rows):
            d, colour = by[part], COLOURS[mode]
            ax.plot([-100 * d.high, -100 * d.low], [k, k], color=colour, linewidth=3)
            ax.plot(-100 * d.saved, k, "o", color=colour)
        ax.set_xlabel(f"{part}, change of time, %")
    axes[0].set_yticks(range(len(rows)), [label for label, _, _ in rows])
    axes[0].set_ylim(-0.6, max(0.6, len(rows) - 0.4))
    return figure


def _paths(site: Site, done: dict[str, Work]) -> Any:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    above, side = figure.subplots(1, 2)
    for mode, work in done.items():
        _, _, grip, _ = chain(work.machine.manipulator, site, work.angles, work.head)
        above.plot(grip[:, 0], grip[:, 1], color=COLOURS[mode], linewidth=0.9, label=mode)
        side.plot(grip[:, 1], grip[:, 2] - site.ground, color=COLOURS[mode], linewidth=0.9)
    for x, y, z in site.stakes:
        above.plot(x, y, "s", color="black", markersize=4)
        side.plot([y, y], [z - site.ground, site.stake_top - site.ground], color="black", linewidth=3)
    for x, y, z in site.places.values():
        above.plot(x, y, "o", color="saddlebrown")
        side.plot(y, z - site.ground, "o", color="saddlebrown")
    above.plot(0.0, 0.0, "^", color="black")
    above.set(xlabel="ahead, over the bunk, m", ylabel="to the left, m", aspect="equal")
    side.set(xlabel="to the left, m", ylabel="above the ground, m", aspect="equal")
    side.axhline(0.0, color="black", linewidth=0.8)
    above.legend(fontsize="small")
    return figure
