"""`forest-study baseline`: our controller and simple policies on the same drawn tasks, judged alike.

A policy of your own is judged by `judged`, on the same seeds.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from forest_description.geometry.kinematics import Links
from forest_description.machine import load_machine
from forest_msgs_py.runtime.command_line import whole
from forest_study.learning import driven_crane, policies, tasks
from forest_study.learning.policies import Policy
from forest_study.results import StudyError, new_directory, require_llvm, write_json

if TYPE_CHECKING:
    from forest_study.learning.crane_env import CraneEnv

COLUMNS = "task", "actions", "policy", "return", "RMS, mm", "max, mm", "reached", "steps/s"
RIVALS: tuple[tuple[str, str, Callable[[Links, int], Policy]], ...] = (
    ("tip", "ours", lambda _links, _seed: policies.ours),
    ("joint", "resolved rates", lambda links, _seed: policies.resolved_rates(links)),
    ("voltages", "resolved rates", lambda links, _seed: policies.resolved_rates(links)),
    *((actions, "random", lambda _links, seed: policies.random(seed)) for actions in driven_crane.NAMES),
    ("voltages", "rest", lambda _links, _seed: policies.rest),
)
"""Actions, name, and the policy of a machine's links and a seed."""


class Figures(NamedTuple):
    """What a policy reached in an episode."""

    seed: int
    total: float  # sum of the rewards
    rms_mm: float  # of the tip's distance
    max_mm: float
    reached: int  # targets
    steps: int
    seconds: float  # that the episode took here
    stopped: bool  # the controller's guard took the levers away


def judged(env: "CraneEnv", policy: Policy, seed: int) -> Figures:
    """Return what a policy reaches in the episode of a seed.

    Args:
        env: `crane_env.CraneEnv`.
        policy: from an observation to an action.
        seed: of task, noise and machine.
    """
    observation, told = env.reset(seed=seed)
    total, distances, truncated, began = 0.0, [], False, time.perf_counter()
    while not truncated:
        observation, reward, _, truncated, told = env.step(policy(observation))
        total += reward
        distances.append(told["distance"])
    took, away = time.perf_counter() - began, 1e3 * np.array(distances)
    return Figures(
        seed=seed,
        total=total,
        rms_mm=float(np.sqrt(np.mean(away**2))),
        max_mm=float(away.max()),
        reached=int(told.get("reached", 0)),
        steps=len(away),
        seconds=took,
        stopped=bool(told["stopped"]),
    )


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    add = parser.add_argument
    add("--machine", default="c180", help="shipped machine or file (default: %(default)s)")
    add("--task", choices=(*tasks.NAMES, "all"), default="all", help="task, or all (default: %(default)s)")
    add(
        "--seed",
        type=whole(0),
        default=0,
        metavar="N",
        help="seed of the first episode (default: %(default)s)",
    )
    add("--seeds", type=whole(1, 1000), default=10, metavar="N", help="episodes (default: %(default)s)")
    add("--mismatch", action="store_true", help="draw the simulated machine by the seed")


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code.

    Raises:
        StudyError: something that it needs is not installed, or is in the directory for results.
        MachineError: the machine is not usable.
    """
    require_llvm("baseline", "learning")
    try:
        from forest_study.learning.crane_env import CraneEnv
    except ModuleNotFoundError as error:
        raise StudyError(f"baseline: {error}: pip install 'forest-crane[learning]'") from error
    machine = load_machine(options.machine)
    new_directory(options.out)
    seeds = range(options.seed, options.seed + options.seeds)
    rows: list[dict[str, Any]] = []
    for task in tasks.NAMES if options.task == "all" else (options.task,):
        for actions, name, made in RIVALS:
            env = CraneEnv(task, actions, machine, options.mismatch)
            found = [judged(env, made(machine.manipulator.links, seed), seed) for seed in seeds]
            episodes = [one._asdict() for one in found]
            rows.append({"task": task, "actions": actions, "policy": name, "episodes": episodes})
            print(_row(task, actions, name, found) if len(rows) > 1 else _head(task, actions, name, found))
    report = {"machine": machine.name, "mismatch": options.mismatch, "rows": rows}
    write_json(options.out / "baseline.json", report)
    print(f"  {options.out / 'baseline.json'}")
    return 0


def _head(*row: Any) -> str:
    return "\n".join([f"| {' | '.join(COLUMNS)} |", "|---" * len(COLUMNS) + "|", _row(*row)])


def _row(task: str, actions: str, name: str, found: Sequence[Figures]) -> str:
    """Return a Markdown row: means of all episodes, the greatest distance, and the speed."""
    total, rms, reached = (
        float(np.mean([getattr(one, key) for one in found])) for key in ("total", "rms_mm", "reached")
    )
    speed = sum(one.steps for one in found) / sum(one.seconds for one in found)
    distances = f"{rms:.1f} | {max(one.max_mm for one in found):.0f} | –"
    told = f"– | – | {reached:.1f}" if task == "reach" else distances
    return f"| {task} | {actions} | {name} | {total:.2f} | {told} | {speed:.0f} |"
