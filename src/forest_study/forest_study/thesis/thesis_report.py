"""`forest-study thesis`: the evaluation of Thesis section 5.2 as files and as a table for the terminal."""

from pathlib import Path
from typing import Any

from forest_study.results import write_json
from forest_study.thesis.thesis_study import study

NAMES = {"velocity_error_y": "velocity error in y, m/s", "position_error_y": "position error in y, m"}


def report(out: Path) -> int:
    """Write `study.json` and six pictures into a directory, print the table; return the exit code."""
    result = study()
    write_json(out / "study.json", result)
    from forest_study.thesis.thesis_plots import draw_figures  # matplotlib takes half a second

    drawn = draw_figures(out)
    print(table(result))
    print("\n".join(f"  {path}" for path in (out / "study.json", *drawn)))
    return 0


def table(result: dict[str, Any]) -> str:
    """Return what a person reads of a study: the quoted numbers, the drifts, the break-even."""
    lines = ["  figure  peak                        scheme  thesis    here  deviation"]
    for row in result["quoted"]:
        name = NAMES[row["quantity"]]
        here = f"{row['thesis']:>8.3f}{row['here']:>8.3f}{row['deviation']:>+11.1%}"
        lines.append(f"  {row['figure']:<8}{name:<28}({row['scheme']}) {here}")
    lines.append(f"  worst deviation {result['worst_deviation']:.1%}")
    lines.append("")
    lines.append("  drift at the end, mm          x       y       z")
    for label, scheme, values in _drifts(result):
        shown = "".join(f"{1e3 * values[f'drift_{axis}']:>8.0f}" for axis in "xyz")
        lines.append(f"  {label:<16}({scheme})    {shown}")
    for scheme, found in result["robustness"].items():
        lines.append(
            f"  ({scheme}) largest position error {1e3 * found['nominal']:.0f} mm, "
            f"{1e3 * found['at_20_percent']:.0f} mm with +-20 %: {found['ratio']:.2f} times"
        )
    ends = ", ".join(f"{mismatch:+.1%}" for mismatch in result["break_even_mismatch"]["any_axis"])
    lines.append(f"  (c) and (d) break even at a mismatch of {ends}")
    return "\n".join([*lines, "", *_sweep(result["mismatch_sweep"])])


def _sweep(rows: list[dict[str, Any]]) -> list[str]:
    """Return the largest position error of every scheme over the 2 Hz plant's mismatch."""
    schemes = [name for name in rows[0] if name != "mismatch"]
    lines = ["  largest position error, mm" + "".join(f"{name:>13}" for name in schemes)]
    for row in rows:
        values = "".join(f"{1e3 * row[name]['position_error']:>13.0f}" for name in schemes)
        lines.append(f"  2 Hz {row['mismatch']:<+21.0%}{values}")
    return lines


def _drifts(result: dict[str, Any]) -> list[tuple[str, str, dict[str, float]]]:
    """Return (case, scheme, metrics) of the nominal 2 Hz plant and of both mismatches."""
    figure = result["figures"]["5.9"]
    rows = [("2 Hz", scheme, result["figures"]["5.5"][scheme]) for scheme in "cd"]
    return rows + [
        (f"2 Hz {case}", scheme, found[scheme]) for case, found in figure["cases"].items() for scheme in "cd"
    ]
