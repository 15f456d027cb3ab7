"""Times the compiled plant against general solvers at equal accuracy; prints a table.

    python benchmarks/plant.py [--json FILE] [--peers NAME ...] [--modes open held] [--seconds 20]
    python benchmarks/plant.py --components

What is integrated, and how to read the table: benchmarks/README.md. Each contestant runs in a process of its
own, one thread, with an empty compiler cache at first.
"""

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import components
import reference
import work as benchmark
from peers import CONTESTANTS, Contestant

Row = dict[str, Any]
THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
HEAD = (
    "| contestant | tolerance | mode | × real time | ours is faster by | error, rad | error, MPa "
    "| first step, s (of CPU): cold | cached |\n|---|---|---|---|---|---|---|---|---|"
)


def run_contestant(
    key: str, modes: list[str], seconds: float, tolerance: float | None, warm: bool = False
) -> list[Row]:
    """Return one row for each mode; a contestant that is not installed or fails says so in its row.

    Warm, ours takes its object code from where it lies, and its first step is no cold start.
    """
    contestant = CONTESTANTS[key]
    row: Row = {"contestant": key, "name": contestant.name}
    if missing := contestant.missing():
        return [row | {"mode": mode, "missing": missing} for mode in modes]
    rows = []
    with tempfile.TemporaryDirectory() as cache:
        cold: Row = {}
        for mode in modes:
            share = min(seconds, contestant.shares.get(mode, seconds))
            setting = tolerance or contestant.tolerance[mode]
            start = row | {"mode": mode, "seconds": share, "tolerance": setting}
            arguments = [key, "--mode", mode, "--seconds", str(share), "--tolerance", str(setting)]
            arguments += ["--reference", str(reference.cached(mode, seconds))]
            try:
                cold = cold or _process([*arguments, "--first-step"], cache, warm)
                result = _process(arguments, cache, warm)
            except subprocess.CalledProcessError as error:
                rows.append(start | {"failed": error.stderr.strip().splitlines()[-1:]})
                continue
            times = {
                "start_cold_s": cold["first_step_s"],
                "start_cold_cpu_s": cold["first_step_cpu_s"],
                "start_cached_s": result.pop("first_step_s"),
                "start_cached_cpu_s": result.pop("first_step_cpu_s"),
            }
            rows.append(start | result | times)
    return rows


def _process(arguments: list[str], cache: str, warm: bool) -> Row:
    """Return what a contestant's process prints."""
    program = str(Path(__file__).resolve().with_name("contest.py"))
    environment = os.environ | dict.fromkeys(THREADS, "1") | {"NUMBA_CACHE_DIR": cache}
    if not warm:
        environment["XDG_CACHE_HOME"] = cache  # where ours keeps its object code
    # The folder is also where CasADi leaves its C files.
    command = [sys.executable, program, *arguments, "--spawned", repr(time.time())]
    done = subprocess.run(command, env=environment, cwd=cache, check=True, capture_output=True, text=True)
    result: Row = json.loads(done.stdout.splitlines()[-1])
    return result


def table(rows: Iterable[Row]) -> Iterable[str]:
    """Return the rows as lines of Markdown."""
    ours: dict[str, float] = {}
    for row in rows:
        if "real_time_factor" not in row:
            reason = "; ".join(row.get("missing", [])) or "; ".join(row["failed"])
            what = "missing" if "missing" in row else "failed"
            yield f"| {row['name']} | | {row['mode']} | {what}: {reason} | | | | | |"
            continue
        factor = row["real_time_factor"]
        if row["contestant"] == "ours":
            ours[row["mode"]] = factor
        ratio = f"{_figures(ours[row['mode']] / factor)}×" if row["mode"] in ours else ""
        flag = "" if accurate(row) else " (misses the limit)"
        yield (
            f"| {row['name']} | {row['tolerance']:.0e} | {row['mode']}{_share(row)} "
            f"| {_figures(factor)} | {ratio} | {row['error_rad']:.1e}{flag} | {row['error_mpa']:.3f} "
            f"| {row['start_cold_s']:.1f} ({row['start_cold_cpu_s']:.1f}) "
            f"| {row['start_cached_s']:.2f} ({row['start_cached_cpu_s']:.2f}) |"
        )


def _figures(value: float) -> str:
    """Return three figures, never an exponent."""
    return f"{float(f'{value:.3g}'):.10g}"


def accurate(row: Row) -> bool:
    """Return whether a row's errors meet both limits."""
    return bool(row["error_rad"] <= benchmark.ERROR_RAD and row["error_mpa"] <= benchmark.ERROR_MPA)


def _share(row: Row) -> str:
    contestant: Contestant = CONTESTANTS[row["contestant"]]
    return f", first {row['seconds']:g} s" if row["mode"] in contestant.shares else ""


def main(argv: list[str] | None = None) -> None:
    """Run the contest."""
    ours = [key for key in CONTESTANTS if key.startswith("ours")]
    peers = [key for key in CONTESTANTS if key not in ours]
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", type=Path, help="also write all numbers to this file")
    parser.add_argument("--peers", nargs="*", choices=peers, default=peers, help="default: all")
    parser.add_argument("--modes", nargs="+", choices=benchmark.MODES, default=list(benchmark.MODES))
    parser.add_argument("--seconds", type=float, default=benchmark.SECONDS, help="length of the work [s]")
    parser.add_argument("--tolerance", type=float, help="for the peers, instead of each one's own")
    parser.add_argument("--warm", action="store_true", help="ours need not be compiled anew")
    parser.add_argument("--components", action="store_true", help="what single components cost, instead")
    args = parser.parse_args(argv)
    if args.components:
        found = components.measure(args.seconds, repeats=50)
        print(components.HEAD, *components.table(found), sep="\n")
        full = components.measure_full(args.seconds, repeats=10)
        print("", components.FULL_HEAD, *components.full_table(full), sep="\n")
        _write(args.json, found + full)
        return

    rows: list[Row] = []
    print(HEAD)
    for key in [*ours, *args.peers]:
        tolerance = None if key in ours else args.tolerance
        rows += run_contestant(key, args.modes, args.seconds, tolerance, args.warm)
        for line in list(table(rows))[-len(args.modes) :]:
            print(line, flush=True)
    _write(args.json, rows)


def _write(path: Path | None, rows: list[Row]) -> None:
    if path is not None:
        machine = {"processor": _processor(), "python": platform.python_version()}
        path.write_text(json.dumps({"machine": machine, "rows": rows}, indent=2) + "\n")


def _processor() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    names = [line.split(":")[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()


if __name__ == "__main__":
    main()
