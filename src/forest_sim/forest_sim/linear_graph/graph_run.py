"""Run a circuit: its state equations, integrated over time with numbers for what they leave open.

An input is a number, or a function of the time [s] and of the states by name. A displacement is the
integral of a branch's across variable (an angle, a position): a state that no element stores, for
inputs that depend on it. The integrator is stiff (Radau IIA, order 5), for hoses of milliseconds
beside loads of seconds.
"""

from collections.abc import Callable, Iterable, Mapping

import numpy as np
import scipy
from numpy.typing import ArrayLike
from sympy import Expr

from forest_description.types import Floats
from forest_sim.linear_graph.linear_graph import GraphError
from forest_sim.linear_graph.state_equations import StateEquations
from forest_sim.linear_graph.symbols import across_symbol, through_symbol

Course = float | Callable[[float, Mapping[str, float]], float]

TOLERANCE = 1e-8  # of a state's value, for every step
SMALLEST = {"P": 1.0, "Q": 1e-9, "W": 1e-9, "t": 1e-3, "V": 1e-9, "F": 1e-3}
"""What a state's error may always be, by its letter [Pa, m^3/s, rad/s, N m, m/s, N]."""
SMALLEST_DISPLACEMENT = 1e-9  # [rad, m]


def run(
    equations: StateEquations,
    inputs: Mapping[str, Course],
    parameters: Mapping[str, float],
    start: Mapping[str, float],
    times: ArrayLike,
    displacements: Mapping[str, str] | None = None,
) -> dict[str, Floats]:
    """Return every variable of a circuit over time, by name: states, displacements, P_1, F_xdot ...

    No step of the integrator is longer than the greatest distance of two times, so that an input
    cannot do something unseen between them. Where an input jumps, end one run and start another.

    Args:
        equations: the circuit.
        inputs: a course for each of its inputs, SI.
        parameters: a value for each of its parameters, SI.
        start: the states at the first time; those that are left out start at zero.
        times: at least two, increasing, shape (N,) [s].
        displacements: the branch whose across variable each of them integrates.

    Raises:
        GraphError: a name is missing or unknown, or the integrator gave up.
    """
    moved, grid = dict(displacements or {}), np.asarray(times, dtype=np.float64)
    states = [symbol.name for symbol in equations.states]
    names = [*states, *moved]
    _require("input", inputs, [symbol.name for symbol in equations.inputs])
    _require("parameter", parameters, [symbol.name for symbol in equations.parameters])
    _require("state at the start", [*names, *start], names)
    _require("displaced branch", [*equations.across, *moved.values()], equations.across)

    def arguments(time: float, state: Floats) -> tuple[Floats, list[float], Mapping[str, float]]:
        now = dict(zip(names, state.tolist(), strict=True))
        courses = [inputs[symbol.name] for symbol in equations.inputs]
        given = [course(time, now) if callable(course) else course for course in courses]
        return state[: len(states)], given, parameters

    rates = equations.function(*equations.derivatives, *(equations.across[b] for b in moved.values()))
    first = np.array([start.get(name, 0.0) for name in names])
    small = [SMALLEST[name[0]] for name in states] + [SMALLEST_DISPLACEMENT] * len(moved)
    rows = _integrated(lambda time, state: rates(*arguments(time, state)), first, grid, small)
    variables = _variables(equations)
    evaluate = equations.function(*variables.values())
    values = [evaluate(*arguments(time, state)) for time, state in zip(grid, rows, strict=True)]
    return dict(zip(variables, np.transpose(values), strict=True)) | dict(zip(names, rows.T, strict=True))


def _integrated(
    slope: Callable[[float, Floats], Floats], first: Floats, times: Floats, small: list[float]
) -> Floats:
    """Return the states at the times, shape (N, states)."""
    solution = scipy.integrate.solve_ivp(
        slope,
        (times[0], times[-1]),
        first,
        method="Radau",
        t_eval=times,
        max_step=np.max(np.diff(times)),
        rtol=TOLERANCE,
        atol=small,
    )
    if not solution.success:
        raise GraphError(f"the integrator stopped: {solution.message}")
    return np.asarray(solution.y.T)


def _variables(equations: StateEquations) -> dict[str, Expr]:
    """Return the expression of every branch's across and through variable by its symbol's name."""
    branches = equations.tree.graph.branches
    across = {across_symbol(branch).name: equations.across[branch.name] for branch in branches}
    return across | {through_symbol(branch).name: equations.through[branch.name] for branch in branches}


def _require(what: str, given: Iterable[str], allowed: Iterable[str]) -> None:
    """Check that exactly the allowed names are given."""
    missing, unknown = sorted(set(allowed) - set(given)), sorted(set(given) - set(allowed))
    if missing or unknown:
        raise GraphError(
            f"{what}: missing {', '.join(missing) or 'none'}, unknown {', '.join(unknown) or 'none'}; "
            f"allowed: {', '.join(sorted(allowed))}"
        )
