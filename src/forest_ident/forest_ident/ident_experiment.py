"""`forest-ident experiment`: a scripted experiment on a simulated machine, as bags like a real session's."""

from __future__ import annotations

import argparse
import dataclasses
from pathlib import Path
from typing import Any

from forest_description.machine import Machine, load_machine
from forest_ident import calibration, experiments, session_bag, simulated
from forest_ident.session import Session, SessionError
from forest_sim.sensor_suite import Suite, sensor_suite


def add_parser(verbs: Any) -> None:
    """Name the verb's flags."""
    text = "run the experiments of the identification on a simulated machine"
    parser = verbs.add_parser("experiment", help=text, description=text[0].upper() + text[1:] + ".")
    parser.set_defaults(command=run)
    parser.add_argument("name", metavar="NAME|all", help="an experiment; 'list' tells them with their set-up")
    parser.add_argument("--machine", default="c180", metavar="NAME|FILE", help="default: %(default)s")
    parser.add_argument(
        "--seed", type=seed_number, default=0, metavar="N", help="of sensors and lots (default: 0)"
    )
    parser.add_argument("--exact", action="store_true", help="exact sensors instead of Table 4.2's")
    parser.add_argument("--out", type=Path, metavar="DIR", help="to be made; gets one bag per experiment")


def seed_number(text: str) -> int:
    """Return the seed that a flag names."""
    value = int(text)
    if not 0 <= value < 2**31:
        raise argparse.ArgumentTypeError(f"{text!r}; allowed: 0 .. {2**31 - 1}")
    return value


def run(options: argparse.Namespace) -> int:
    """Run the verb; return its exit code.

    Raises:
        SessionError: no such experiment, or no directory for it.
    """
    machine = load_machine(options.machine)
    known = experiments.names(machine)
    if options.name == "list":
        print("\n\n".join(_told(name, machine) for name in known))
        return 0
    wanted = known if options.name == "all" else (options.name,)
    if options.name != "all" and options.name not in known:
        raise SessionError(
            f"no experiment {options.name!r} for {machine.name}; allowed: all, {', '.join(known)}"
        )
    if options.out is None:
        raise SessionError("experiment: --out DIR is missing")
    if options.out.exists():
        raise SessionError(f"{options.out} exists already; choose another --out or remove it")
    options.out.mkdir(parents=True)
    for name in wanted:
        session = experiment(name, machine, options.seed, options.exact)
        print(_told(name, machine), flush=True)
        session_bag.write(session, options.out / name)
        print(f"  {len(session.time) * session.period:.0f} s recorded: {options.out / name}\n", flush=True)
    return 0


def experiment(name: str, machine: Machine, seed: int = 0, exact: bool = False) -> Session:
    """Return the record of an experiment on a simulated machine.

    Args:
        name: one of `experiments.names`.
        machine: the crane.
        seed: of the sensors' static errors and noise, and of levels drawn by lot.
        exact: whether sensors are exact.
    """
    if name == "calibration":
        session = calibration.simulated(_suite(machine, seed, exact))
        facts = dict(session.facts)
    else:
        plan = experiments.plan(name, machine, seed)
        suite = _suite(plan.machine, seed, exact)
        session = simulated.run(name, plan.machine, plan.programme, plan.angles, suite, plan.bench)
        facts = {**plan.facts, **session.facts}
    if exact:
        facts["exact_sensors"] = 1.0
    return dataclasses.replace(session, facts=facts)


def _suite(machine: Machine, seed: int, exact: bool) -> Suite:
    return sensor_suite(machine, noise=not exact, seed=seed)


def _told(name: str, machine: Machine) -> str:
    """Return what a person must do for an experiment, and within which limits it runs."""
    if name == "calibration":
        return f"{name}\n  by hand: {calibration.SETUP}"
    plan = experiments.plan(name, machine)
    return f"{name}: {plan.programme.duration:.0f} s\n  by hand: {plan.setup}\n  limits: {plan.limits}"
