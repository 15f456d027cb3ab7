"""The signals in which two bags differ most, against their own size: both, and their difference."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from forest_bag.compare.alignment import interpolated
from forest_bag.compare.comparison import Comparison
from forest_bag.plots.standard_plots import finish_axes, new_figure
from forest_bag.read.timeseries import Bag, NotInBag, Series, read_bag
from forest_msgs_py.types import NS_PER_S

PANELS = 6  # signals in the picture
PANEL_HEIGHT = 2.2  # [in]


class _Ranked(NamedTuple):
    share: float  # largest difference over the signal's span in a
    topic: str
    label: str


def draw(comparison: Comparison, a: Path, b: Path, file: Path) -> None:
    """Draw the picture.

    Args:
        comparison: what was found.
        a: one bag.
        b: the other.
        file: to be written; the end of its name says the format.

    Raises:
        OSError: it cannot be written.
    """
    topics = [t.topic for t in comparison.topics.values() if any(s.largest for s in t.signals.values())]
    bags = read_bag(a, topics), read_bag(b, topics)
    ranked = _ranked(comparison, bags[0])
    title = f"A: {a}\nB: {b}"
    if not ranked:
        figure, (axes,) = new_figure(1, 1, PANEL_HEIGHT, title)
        axes.set_axis_off()
        axes.text(0.5, 0.5, "no signal differs", ha="center", va="center", transform=axes.transAxes)
    else:
        figure, panels = new_figure(len(ranked), 2, PANEL_HEIGHT * len(ranked) + 0.6, title)
        for row, (_, topic, label) in enumerate(ranked):
            last = "time [s]" if row == len(ranked) - 1 else ""
            series = bags[0].series(topic), bags[1].series(topic)
            left, right = panels[2 * row : 2 * row + 2]
            unit = series[0].units[series[0].labels.index(label)]
            times = [(s.time_ns - o) / NS_PER_S for s, o in zip(series, comparison.origins, strict=True)]
            for name, time, one, style in zip("AB", times, series, ("-", "--"), strict=True):
                left.plot(time, one.column(label), style, label=name)
            right.plot(times[0], _difference(series, comparison.origins, label), "C3", label="B − A")
            left.set_title(f"{topic} {label}", fontsize="small")
            finish_axes(left, f"[{unit}]", last, legend=row == 0)
            finish_axes(right, f"[{unit}]", last, legend=row == 0)
    figure.savefig(file)


def _difference(series: tuple[Series, Series], origins: tuple[int, int], label: str) -> np.ndarray:
    a, b = series
    return interpolated(b.time_ns - origins[1], b.column(label), a.time_ns - origins[0]) - a.column(label)


def _ranked(comparison: Comparison, bag: Bag) -> list[_Ranked]:
    found = []
    for topic in comparison.topics.values():
        for signal in topic.signals.values():
            if not signal.largest:
                continue
            try:
                values = bag.series(topic.topic).column(signal.label)
            except NotInBag:
                continue
            span = float(np.nanmax(values) - np.nanmin(values)) if np.isfinite(values).any() else 0.0
            found.append(_Ranked(signal.largest / (span or 1e-300), topic.topic, signal.label))
    return sorted(found, reverse=True)[:PANELS]
