"""A picture of what was foretold of a record, and of what was measured where that is known."""

from __future__ import annotations

from pathlib import Path

from matplotlib.figure import Figure

from forest_description.types import Floats
from forest_ident.actuator.record import Record


def draw(path: Path, test: Record, foretold: Floats) -> None:
    """Write a PNG: the valve's signal above, pressure below, measured solid and foretold dotted."""
    figure = Figure(figsize=(10, 5), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(1, 2.5))
    above.plot(test.samples, test.valve, "k", linewidth=1.0)
    above.set_ylabel("valve")
    if test.pressure is not None:
        below.plot(test.samples, test.pressure, "k", linewidth=1.2, label="measured")
    below.plot(test.samples, foretold, "r:", linewidth=1.6, label="simulated from the valve's signal")
    below.set_xlabel("sample")
    below.set_ylabel("pressure")
    below.legend(loc="upper right", fontsize=8)
    for axes in (above, below):
        axes.grid(linewidth=0.3)
    figure.savefig(path, dpi=110)
