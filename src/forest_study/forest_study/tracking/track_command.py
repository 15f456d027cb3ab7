"""`forest-study track`: one run or many along one path or all, the tip's errors told and drawn.

With `--through-ros` the nodes make every run a second time, over DDS in lockstep. The figures are then those
of their bags, and must be those of the loop without ROS.
"""

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from forest_bringup.graph_lock import GraphError
from forest_bringup.profile_choice import add_profile_option
from forest_control.config.profile_file import with_gains_of
from forest_control.servo.joint_angle_filter import Source
from forest_control.servo.schemes import LABELS, scheme_named
from forest_control.taught.tip_path import PathError, TipPath
from forest_control.valve.unlearnt_valves import told
from forest_description.machine import Machine, load_machine
from forest_msgs_py.runtime.command_line import number, whole
from forest_study.closed_loop import model_mismatch
from forest_study.results import StudyError, new_directory, require_llvm, write_json
from forest_study.tracking.paths import NAMES, path_named
from forest_study.tracking.scores import Score
from forest_study.tracking.track_runs import Run, Variation, quantiles, run_many
from forest_study.tracking.tracking import Course, Session, follow, noisy, prepare, scored

MEASURES = ("governed", "cross_track", "wish")  # of `scores.Score`, each an RMS and a greatest error
COLUMNS = (
    *("path", "governed, mm", "cross-track, mm", "wish, mm", "time lost, s", "end, mm"),
    *("velocity RMS, m/s", "duration, s", "saturated, s"),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parser.add_argument
    corners = "smooth where it turns by less than 25 deg; it stops at corners and at points that are repeated"
    add("--path", required=True, help=f"{', '.join(NAMES)}, all, or a CSV of waypoints x,y,z [m]: {corners}")
    add("--speed", type=number(0.01, 3.0, "m/s"), default=0.5, metavar="V", help="m/s (default: %(default)s)")
    add("--scheme", choices=[label for label in LABELS if label != "joint"], default="coordinated")
    sources = [source.name.lower() for source in Source]
    text = "sensors of boom and stick (default: %(default)s)"
    add("--position-source", choices=sources, default=Source.CYLINDERS.name.lower(), help=text)
    add("--machine", default="c180", help="simulated machine, shipped or a file (default: %(default)s)")
    add("--model", help="machine file of controller and driver (default: the simulated one)")
    add_profile_option(parser, "profile whose gains are used, as tune writes them; its lever curves are not")
    add("--noise", action="store_true", help="simulate the sensors' noise")
    add("--static-errors", action="store_true", help="with --noise: uncalibrated sensors")
    add("--seed", type=whole(0), default=0, metavar="N", help="seed of the first run (default: %(default)s)")
    add(
        "--runs",
        "--seeds",
        type=whole(1, 1000),
        default=1,
        metavar="N",
        help="runs per path, each with its own seed",
    )
    add(
        "--mismatch",
        type=model_mismatch.ranges_from,
        nargs="?",
        const=model_mismatch.Ranges(),
        metavar="RANGES",
        help=model_mismatch.HELP,
    )
    learns = "the valve driver learns deadbands and gains on the way (default: it does)"
    add("--adapt", action=argparse.BooleanOptionalAction, default=True, help=learns)
    add(
        "--laps", type=whole(1, 1000), default=1, metavar="N", help="laps of each path (default: %(default)s)"
    )
    add("--through-ros", action="store_true", help="run the nodes, in lockstep; the figures are the same")


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        PathError: the path cannot be read or followed.
        MachineError: a machine's file cannot be.
        StudyError: LLVM is not installed, something is in the directory for results, or options contradict.
        GraphError: a run through ROS failed, or gave other figures.
    """
    require_llvm("track")
    if options.through_ros and options.mismatch:
        raise StudyError("track: --through-ros does not go with --mismatch: nodes read machines from files")
    if options.static_errors and not options.noise:
        raise StudyError("track: --static-errors goes with --noise: without it the sensors are exact")
    machine = load_machine(options.machine)
    model = load_machine(options.model) if options.model else machine
    paths = [path_named(name) for name in (NAMES if options.path == "all" else (options.path,))]
    new_directory(options.out)
    report, failed = _run_all(paths, machine, model, options)
    if len(failed) == len(paths):
        raise PathError("; ".join(failed))
    write_json(options.out / "track.json", report)
    print(table(report))
    if options.adapt and (unlearnt := told(model)):
        print(f"  --adapt learns nothing at {unlearnt}")
    print(f"  {options.out / 'track.json'}")
    if failed:
        raise PathError("; ".join(failed))
    if options.through_ros:
        _judge(report["runs"])
    return 0


def _judge(runs: list[dict[str, Any]]) -> None:
    """Say whether the figures through ROS are those without it.

    Raises:
        GraphError: they are not.
    """
    most = max(run["differences"]["tip_m"] for run in runs)
    other = [f"{run['path']}, seed {run['seed']}" for run in runs if not run["same"]]
    if other:
        where = f"{'; '.join(other)}; the tip is up to {most:g} m apart"
        raise GraphError(f"track: through ROS the figures are others than without it: {where}")
    print(f"  through ROS and without it the figures are the same; the tip is at most {most:g} m apart")


def _run_all(
    paths: list[TipPath], machine: Machine, model: Machine, options: argparse.Namespace
) -> tuple[dict[str, Any], list[str]]:
    """Return the report of every path and seed, and why paths are not in it; draw every path's first run."""
    from forest_study.tracking.track_plot import draw, draw_runs  # matplotlib takes half a second

    report: dict[str, Any] = {
        "machine": machine.name,
        "model": model.name,
        "scheme": options.scheme,
        "profile": options.profile,
        "position_source": options.position_source,
        "speed": options.speed,
        "adapt": options.adapt,
        "noise": options.noise,
        "static_errors": options.static_errors,
        "mismatch": options.mismatch and options.mismatch._asdict(),
        "runs": [],
        "quantiles": {},
    }
    seeds = range(options.seed, options.seed + options.runs)
    scheme, source = scheme_named(options.scheme), Source[options.position_source.upper()]
    failed = []
    for path in paths:
        try:
            course = prepare(path, options.speed, scheme, model, options.laps, source)
            if options.profile:
                course = course._replace(settings=with_gains_of(course.settings, options.profile))
            varied = partial(_varied, machine, options)
            runs, session = run_many(course, machine, seeds, varied, options.adapt)
        except PathError as error:
            failed.append(str(error))
            continue
        compared: list[dict[str, Any]] = [{}] * len(runs)
        if options.through_ros:
            runs, session, compared = _through_ros(course, machine, seeds, varied, options)
        report["runs"] += [made.told(path.name) | more for made, more in zip(runs, compared, strict=True)]
        report["quantiles"][path.name] = quantiles(runs)
        draw(session, options.out / f"{path.name}.png")
    if options.runs > 1:
        draw_runs(report, options.out / "runs.png")
    return report, failed


def _through_ros(
    course: Course,
    machine: Machine,
    seeds: Sequence[int],
    varied: Callable[[int], Variation],
    options: argparse.Namespace,
) -> tuple[list[Run], Session, list[dict[str, Any]]]:
    """Return every seed's figures, the first one's session, and how they differ from the loop without ROS."""
    from forest_study.tracking import track_ros  # only here: nothing else needs ROS

    sessions, compared = [], []
    for seed in seeds:
        name = f"{course.drawn[0].lap.path.name}-seed{seed}"
        print(f"through ROS: {name}", flush=True)
        graph = track_ros.GraphSettings(
            *(options.machine, options.model or options.machine, options.adapt),
            *(options.noise, options.static_errors, seed),
        )
        alone = follow(course, machine, varied(seed).suite, options.adapt)
        moved = track_ros.run(course, alone.led.levers, graph, options.out / name)
        sessions.append(scored(course, alone.led._replace(moved=moved), machine))
        compared.append(track_ros.comparison(alone, sessions[-1]))
    runs = [Run(seed, one.total, one.scores, None) for seed, one in zip(seeds, sessions, strict=True)]
    return runs, sessions[0], compared


def _varied(machine: Machine, options: argparse.Namespace, seed: int) -> Variation:
    suite = noisy(machine, seed, options.static_errors) if options.noise else None
    return Variation(suite, model_mismatch.draw(seed, options.mismatch) if options.mismatch else None)


def table(report: dict[str, Any]) -> str:
    """Return a Markdown table: per path, and lap if several, mean RMS and greatest error of all runs."""
    lines = [f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|"]
    for name in dict.fromkeys(run["path"] for run in report["runs"]):
        of = [run for run in report["runs"] if run["path"] == name]
        laps = len(of[0]["laps"])
        if laps == 1:
            lines.append(_row(name, of))
        else:
            lines += [_row(f"{name}, lap {k + 1}", [run["laps"][k] for run in of]) for k in range(laps)]
    return "\n".join(lines)


def _row(name: str, scores: list[dict[str, Any]]) -> str:
    mean = {key: sum(score[key] for score in scores) / len(scores) for key in Score._fields}
    most = {key: max(score[key] for score in scores) for key in Score._fields}
    errors = (f"{mean[f'{key}_rms_mm']:.2f} / {most[f'{key}_max_mm']:.1f}" for key in MEASURES)
    return (
        f"| {name} | {' | '.join(errors)} | {round(most['time_lost_s'], 2) + 0.0:.2f} | {most['end_mm']:.1f} "
        f"| {mean['velocity_rms']:.4f} | {mean['duration_s']:.2f} | {mean['saturated_s']:.2f} |"
    )
