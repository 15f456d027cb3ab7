"""What does `forest-ident fit` make of cranes that are not its model? Drawn, recorded, fitted, driven.

    python benchmarks/foreign_coverage.py [--structures NAME ...] [--draws 2] [--seed 1] [--trial S]
                                          [--without NAME ...] [--json FILE]

Each session is a drawn crane of one structure (`test/helpers/foreign_plants.py`), all its experiments as
`forest-ident experiment all --direct` records them, the fit from the told machine, the held-out record, and
the tip's way along the paths with the identified and with the exact file. With --json every finished session
is written at once, and those that the file holds are not run again.

Per structure is printed: how often the 95 % intervals that were given without a doubt held the truth; how
many estimates were doubted; the worst deviation from the truth; velocity's NRMSE of the held-out record; the
tip's RMS over that with the exact file; the verdict; and the physics that residuals were said to look like.
"""

import argparse
import json
import math
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "helpers"))

from foreign_plants import STRUCTURES, TOLD, Foreign, foreign

from forest_control.servo.schemes import scheme_named
from forest_control.taught.tip_path import PathError
from forest_description.machine import Machine
from forest_ident.driving.simulated_experiment import experiment
from forest_ident.experiments import experiment_plan
from forest_ident.measurements.session import RIGS, Session
from forest_ident.model_choice import residual_patterns
from forest_ident.model_choice.residual_patterns import times_noise
from forest_ident.refinement.identification import identify
from forest_ident.refinement.result import Refined, Result, value_in
from forest_ident.report import machine_writer
from forest_ident.validation import prediction_error
from forest_ident.validation.verdict import BUT_FOR, NOT_TRUSTED, TRUSTED, verdict
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import noisy, track
from interval_coverage import NORMAL_95, source

PATHS = ("sweep", "radial", "vertical")
SPEED = 0.5  # [m/s]
Told = dict[str, Any]


def trial(structure: str, seed: int, longest: float = math.inf, without: Sequence[str] = ()) -> Told:
    """Return what a session of a structure told: errors of the estimates, remarks, tracking; or the crash."""
    began, plant = time.process_time(), foreign(structure, seed)
    told: Told = {
        "structure": structure,
        "seed": seed,
        "longest": longest,
        "without": without,
        "source": source(),
    }
    names = [name for name in experiment_plan.names(plant.told) if name not in without]
    try:
        sessions = [_record(name, plant, seed, longest) for name in names]
        result = identify(plant.told, sessions)
        told |= _accuracy(plant, result)
        told["looks_like"] = {one.session.name: _looks_like(result, one) for one in result.refined}
        with tempfile.TemporaryDirectory() as folder:
            found = machine_writer.write(result, TOLD, Path(folder) / "found.yaml")
        held_out = next(session for session in sessions if session.name == "validation")
        signals = prediction_error.signals(found, held_out)
        judged = verdict(result, [("validation", signals)])
        told |= {"verdict": judged.code, "reasons": judged.reasons, "doubts": judged.doubts}
        told["nrmse"] = {f"{s.axis} {s.name}": round(s.nrmse, 5) for s in signals}
        told["tip_mm"] = {name: _tip(name, plant, found, seed) for name in PATHS}
    except Exception as error:  # noqa: BLE001 a crash is a finding, and the next session goes on
        told["crash"] = f"{type(error).__name__}: {error}"
    return told | {"cpu_s": round(time.process_time() - began, 1)}


def _record(name: str, plant: Foreign, seed: int, longest: float) -> Session:
    """Return an experiment's record; what is driven on the crane is cut off."""
    on_rig = name.partition("_")[0] in RIGS
    return experiment(name, plant.crane, seed, longest=math.inf if on_rig else longest)


def _accuracy(plant: Foreign, result: Result) -> Told:
    """Return deviations [share; overlaps: V] and errors over standard errors of what was found."""
    off, away = {}, {}
    for key, e in result.estimates.items():
        truth = value_in(plant.crane, key)
        if truth is None or not (math.isfinite(e.value) and e.standard_error > 0.0):
            continue
        log = e.positive and e.value > 0.0
        error = math.log(e.value / truth) if log else e.value - truth
        away[key] = round(error / (e.standard_error / (e.value if log else 1.0)), 2)
        off[key] = float(f"{error:.3g}")
    named = [one.sentence() for one in residual_patterns.findings(result)]
    return {"off": off, "away": away, "remarks": result.remarks, "named": named}


def _looks_like(result: Result, refined: Refined) -> Told:
    """Return residuals over noise of a record, and what the candidates of `model_choice` explain of them."""
    ranked = residual_patterns.ranking(result.machine, refined)
    shares = {one.candidate.name: [round(one.share, 3), round(one.size, 2)] for one in ranked}
    return {"times_noise": round(times_noise(refined), 1), "shares": shares}


def _tip(name: str, plant: Foreign, found: Machine, seed: int) -> list[float]:
    """Return the tip's RMS [mm] to the reference with the identified, the exact and the told file.

    It is inf with a file that does not bring the tip to the path's end.
    """
    path, scheme = path_named(name), scheme_named("coordinated")

    def rms(model: Machine) -> float:
        try:
            run = track(path, SPEED, scheme, plant.crane, model, noisy(plant.crane, seed))
        except PathError:
            return math.inf
        return round(run.total.governed_rms_mm, 3)

    return [rms(model) for model in (found, plant.crane, plant.told)]


def row(structure: str, sessions: list[Told]) -> str:
    """Return a structure's row of the table."""
    whole = [one for one in sessions if "crash" not in one]
    kept = [
        abs(z) <= NORMAL_95 for one in whole for key, z in one["away"].items() if key not in one["doubts"]
    ]
    doubted = sum(key in one["doubts"] for one in whole for key in one["away"])
    held = f"{sum(kept)} of {len(kept)} ({100.0 * float(np.mean(kept)):.0f} %)" if kept else "none given"
    speed = max((v for one in whole for k, v in one["nrmse"].items() if k.endswith("velocity")), default=0.0)
    tips = [run for one in whole for run in one["tip_mm"].values()]
    ratio, untold = (max((run[k] / run[1] for run in tips), default=math.nan) for k in (0, 2))
    crashed = f", {len(sessions) - len(whole)} crashed" if len(whole) < len(sessions) else ""
    cells = (
        *(structure, f"{len(sessions)}{crashed}", held, f"{doubted}", _worst(whole)),
        *(f"{100.0 * speed:.2g} %", f"{ratio:.2f} ({untold:.1f})", _verdicts(whole), _named(whole)),
    )
    return f"| {' | '.join(cells)} |"


def _worst(sessions: list[Told]) -> str:
    """Return the greatest deviations of an overlap and of another parameter, whatever was doubted."""
    worst = {"V": (0.0, ""), "%": (0.0, "")}
    for key, error in ((key, error) for one in sessions for key, error in one["off"].items()):
        unit = "V" if key.endswith("deadband_voltage") else "%"
        size = abs(error) if unit == "V" else 100.0 * abs(math.expm1(error))
        worst[unit] = max(worst[unit], (size, key))
    return f"{worst['V'][0]:.2g} V; {worst['%'][0]:.3g} % ({worst['%'][1]})"


def _verdicts(sessions: list[Told]) -> str:
    words = {TRUSTED: "trusted", BUT_FOR: "trusted but for some", NOT_TRUSTED: "not trusted"}
    counted = Counter(words[one["verdict"]] for one in sessions)
    return ", ".join(f"{word} {count}" for word, count in counted.most_common())


def _named(sessions: list[Told]) -> str:
    """Return the physics that were named, with the number of records that did."""
    counted = Counter(text.partition("--allow ")[2].rstrip("`") for one in sessions for text in one["named"])
    return ", ".join(f"{name} {count}" for name, count in counted.most_common()) or "nothing"


def table(sessions: dict[str, Told]) -> str:
    """Return the table of all structures that there are sessions of."""
    names = ("structure", "draws", "intervals that hold", "doubted", "worst deviation", "velocity NRMSE")
    names = (*names, "tip ratio (told file)", "verdict", "named in records")
    lines = [f"| {' | '.join(names)} |", f"|{'---|' * len(names)}"]
    for structure in STRUCTURES:
        own = [one for one in sessions.values() if one["structure"] == structure]
        if own:
            lines.append(row(structure, own))
    return "\n".join(lines)


def main() -> None:
    """Run the sessions; print and write what they told."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--structures", nargs="+", choices=STRUCTURES, default=STRUCTURES, metavar="NAME")
    parser.add_argument("--draws", type=int, default=2, metavar="N")
    parser.add_argument("--seed", type=int, default=1, help="of the first draw")
    help_trial = "what is driven on the crane is cut off after so many seconds"
    parser.add_argument("--trial", type=float, default=math.inf, metavar="S", help=help_trial)
    help_without = "experiments that are not made"
    parser.add_argument("--without", nargs="+", default=(), metavar="NAME", help=help_without)
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args()
    kept = json.loads(options.json.read_text()) if options.json and options.json.exists() else {}
    wanted = [
        (name, options.seed + k, f"{name}:{options.seed + k}")
        for k in range(options.draws)
        for name in options.structures
    ]
    for structure, seed, place in wanted:
        if place in kept:
            continue
        kept[place] = one = trial(structure, seed, options.trial, options.without)
        print(f"{place}, {one['cpu_s']:.0f} s: {one.get('crash', one.get('tip_mm'))}", flush=True)
        if options.json is not None:
            options.json.write_text(json.dumps(kept, indent=1) + "\n")
    counted = {place: kept[place] for _, _, place in wanted}
    print(table(counted))
    print(f"CPU time {sum(one['cpu_s'] for one in counted.values()):.0f} s of {len(counted)} sessions")


if __name__ == "__main__":
    main()
