"""The picture of a delay study: tracking and stop distance against delay, the threshold marked."""

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

from forest_study.latency.delay_study import THRESHOLD, WAYS


def draw(report: dict[str, Any], file: Path) -> None:
    """Draw a report into a file."""
    figure, axes = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    delays = [1e3 * delay for delay in report["delays"]]
    for ax, key, label in zip(
        axes, ("rms_mm", "stop_mm"), ("tracking RMS, mm", "stop distance, mm"), strict=True
    ):
        for way in WAYS:
            ax.plot(delays, [one[key] for one in report[way]], "o-", label=way)
        ax.axvspan(1e3 * THRESHOLD[0], 1e3 * THRESHOLD[1], color="0.85", label="threshold of the literature")
        ax.set(xlabel="delay, ms", ylabel=label, ylim=(0, None))
        ax.legend()
    figure.savefig(file, dpi=110)
    plt.close(figure)
