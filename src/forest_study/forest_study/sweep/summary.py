"""A study's table and picture: how the figures spread, and which factors make them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from forest_study.sweep.design import combinations
from forest_study.sweep.shares import Share, figure_names, shares
from forest_study.sweep.study import Study
from forest_study.sweep.workers import Row

QUANTILES = {"median": 0.5, "95 %": 0.95, "greatest": 1.0}


def summary(study: Study, rows: Sequence[Row]) -> dict[str, Any]:
    """Return quantiles of each figure by combination of the lists, shares, and what failed."""
    whole = [row for row in rows if row["error"] is None]
    failed: dict[str, int] = {}
    for row in rows:
        if row["error"] is not None:
            failed[row["error"]] = failed.get(row["error"], 0) + 1
    names = figure_names(study, whole) if whole else []
    return {
        "runs": len(rows),
        "failed": failed,
        "quantiles": [
            {"combination": told, **_quantiles([row for row in whole if row["combination"] == c], names)}
            for c, told in enumerate(combinations(study))
        ],
        "shares": {name: _told(shares(study, rows, name)) for name in names},
    }


def _told(found: dict[str, Share]) -> dict[str, dict[str, float | None]]:
    return {factor: share._asdict() for factor, share in found.items()}


def _quantiles(rows: Sequence[Row], names: Sequence[str]) -> dict[str, dict[str, float]]:
    return {
        name: {key: float(np.quantile([row[name] for row in rows], q)) for key, q in QUANTILES.items()}
        for name in names
        if rows
    }


def table(report: dict[str, Any]) -> str:
    """Return the report as Markdown: a table of quantiles for each combination, then one of shares."""
    lines = [f"{report['runs']} runs, {sum(report['failed'].values())} failed"]
    lines += [f"- {count}: {error}" for error, count in report["failed"].items()]
    for one in report["quantiles"]:
        combination = ", ".join(f"{key} {value}" for key, value in one["combination"].items())
        lines += [
            "",
            combination or "all runs",
            "",
            f"| figure | {' | '.join(QUANTILES)} |",
            "|---|---|---|---|",
        ]
        lines += [
            f"| {name} | {' | '.join(f'{x:.4g}' for x in told.values())} |"
            for name, told in one.items()
            if name != "combination"
        ]
    factors = list(next(iter(report["shares"].values()), {}))
    if factors:
        lines += ["", "share of the variance (with others)", ""]
        lines += [f"| figure | {' | '.join(factors)} |", "|---" * (1 + len(factors)) + "|"]
        for name, by_factor in report["shares"].items():
            told = [_share(Share(**by_factor[factor])) if factor in by_factor else "" for factor in factors]
            lines.append(f"| {name} | {' | '.join(told)} |")
    return "\n".join(lines)


def _share(share: Share) -> str:
    return f"{share.first:.2f}" if share.total is None else f"{share.first:.2f} ({share.total:.2f})"


def draw(report: dict[str, Any], file: Path) -> None:
    """Draw the shares of all factors in all figures."""
    from matplotlib.figure import Figure  # half a second

    by_figure = {name: found for name, found in report["shares"].items() if found}
    if not by_figure:
        return
    factors = list(next(iter(by_figure.values())))
    grid = np.array([[found[factor]["first"] for factor in factors] for found in by_figure.values()])
    figure = Figure(figsize=(2.5 + 1.2 * len(factors), 1.2 + 0.35 * len(grid)), layout="constrained")
    axes = figure.subplots()
    axes.imshow(grid, vmin=0.0, vmax=1.0, cmap="Blues", aspect="auto")
    axes.set_xticks(range(len(factors)), [name.replace(".", ".\n") for name in factors])
    axes.set_yticks(range(len(by_figure)), list(by_figure))
    for (i, j), share in np.ndenumerate(grid):
        axes.text(j, i, f"{share:.2f}", ha="center", va="center", color="white" if share > 0.6 else "black")
    axes.set_title(f"share of the variance, {report['runs']} simulated runs")
    figure.savefig(file, dpi=120)
