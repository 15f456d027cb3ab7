"""`forest-study thesis --plant machine`: the study on the full machine as files and as tables."""

from pathlib import Path
from typing import Any

import numpy as np

from forest_bag.plots.standard_plots import finish_axes, new_figure
from forest_control.servo.schemes import LABELS, Scheme
from forest_study.results import write_json
from forest_study.thesis.thesis_machine import PLANTS, Trial, motion, study
from forest_study.thesis.thesis_study import COORDINATES

HEIGHT = 8.0  # [in]
COLOURS = {scheme: f"C{scheme}" for scheme in Scheme}


def report(out: Path) -> int:
    """Write `study.json` and pictures into a directory, print the tables; return the exit code."""
    result = study()
    write_json(out / "study.json", result)
    drawn = [draw_plant(name, out / f"{name.replace(' ', '_').replace('.', '_')}.png") for name in PLANTS]
    drawn.append(draw_mismatch(result, out / "mismatch.png"))
    print(tables(result))
    print("\n".join(f"  {path}" for path in (out / "study.json", *drawn)))
    return 0


def tables(result: dict[str, Any]) -> str:
    """Return two Markdown tables: by plant RMS / largest position error, largest over mismatch; mm."""
    plants, rows = list(result["plants"]), result["mismatch_sweep"]
    lines = ["| RMS / max, mm | " + " | ".join(plants) + " |", "|---" * (len(plants) + 1) + "|"]
    for label in LABELS:
        cells = [_pair(result["plants"][plant][label]) for plant in plants]
        lines.append(f"| `{label}` | " + " | ".join(cells) + " |")
    lines += ["", "| max, mm, as built | " + " | ".join(f"{row['mismatch']:+.0%}" for row in rows) + " |"]
    lines.append("|---" * (len(rows) + 1) + "|")
    for label in LABELS:
        cells = [f"{1e3 * row[label]['position_error']:.0f}" for row in rows]
        lines.append(f"| `{label}` | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def _pair(found: dict[str, float]) -> str:
    return f"{1e3 * found['position_rms']:.0f} / {1e3 * found['position_error']:.0f}"


def draw_plant(name: str, file: Path) -> Path:
    """Draw the tip's position and its error on a plant, all schemes."""
    figure, panels = new_figure(3, 2, HEIGHT, f"The thesis' input on the full machine, spools {name}")
    for scheme in Scheme:
        run = motion(Trial(scheme, name))
        for i in range(len(COORDINATES)):
            style: dict[str, Any] = {"color": COLOURS[scheme], "label": scheme.label, "linewidth": 1.0}
            panels[2 * i].plot(run.time, run.position[:, i] - run.position[0, i], **style)
            panels[2 * i + 1].plot(run.time, 1e3 * run.position_error[:, i], **style)
            if scheme == Scheme.COORDINATED:
                wished = run.wished_position[:, i] - run.wished_position[0, i]
                panels[2 * i].plot(run.time, wished, "k--", linewidth=1.0, label="wished")
    for i, axis in enumerate(COORDINATES):
        under = "time [s]" if axis == COORDINATES[-1] else ""
        finish_axes(panels[2 * i], f"{axis} [m]", under, legend=False)
        finish_axes(panels[2 * i + 1], f"error in {axis} [mm]", under, legend=False)
    panels[0].legend(loc="lower center", bbox_to_anchor=(1.1, 1.0), fontsize="small", ncols=4, frameon=False)
    figure.savefig(file)
    return file


def draw_mismatch(result: dict[str, Any], file: Path) -> Path:
    """Draw the largest position error of every scheme over the mismatch."""
    figure, panels = new_figure(1, 1, 0.6 * HEIGHT, "Valves that are not what controller and driver believe")
    rows = result["mismatch_sweep"]
    share = 100.0 * np.array([row["mismatch"] for row in rows])
    for scheme in Scheme:
        error = [1e3 * row[scheme.label]["position_error"] for row in rows]
        panels[0].plot(share, error, "o-", color=COLOURS[scheme], label=scheme.label)
    panels[0].set_yscale("log")
    finish_axes(panels[0], "largest position error [mm]", "mismatch [%]")
    figure.savefig(file)
    return file
