"""The search of an output-error fit: Gauss-Newton with Marquardt's damping, of few simulations.

It begins with the parameters whose start may be far off, by the rough model if there is one. All derivatives
come after that, a simulation each, and are kept as long as steps grow shorter. The exact model is simulated
at the end alone, where there is a rough one; where there is none, derivatives are bent along the steps.
Symbols as in `output_error`.
"""

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from forest_description.config.parameter import MachineError
from forest_description.types import Floats
from forest_ident.output_error.fit_problem import FAR, Channel, Columns, Jacobian, Problem, Unknown
from forest_ident.output_error.gaussian_estimate import inverse

ITERATIONS = 40
DAMPING = 1e-10  # at the start: so small that a valley of 4e-8 of the curvature across it is seen
GREAT = 1e-3  # from where a refused step is damped more by smaller shares
TRIES = 8  # of one step, each with more damping
CONVERGED = 0.1  # of the standard errors, that the last step moved what other records feel, too
STALE = 0.03  # of a positive parameter, from where derivatives were taken, to take them again
NEAR = 3e-4  # the same, on a rig: its meters' gains hang together with all that it tells (`Search`)
SHARE = 0.25  # of a standard error, the same: what hardly acts may move far
SLOW = 0.3  # of the last step; after a longer step derivatives are taken again, too
BENT = 4  # so many longer steps are allowed where derivatives are bent
LITTLE = 0.03  # by which a step lowers the cost at least, if the search is to go on: 1 is a standard error
USELESS = 0.01  # share of the cost, the same, where the model does not explain the record

Model = Callable[[Mapping[str, float]], Columns]


class Place(NamedTuple):
    """Where a step has led."""

    theta: Floats
    predicted: dict[str, Floats]
    damping: float  # of the next step
    moved: float  # greatest move of what is passed on, in standard errors, stated numbers counted
    fall: float  # of the cost
    errors: Floats  # standard errors of theta


class Effects(NamedTuple):
    """How predictions of the rough model change by what no parameter is."""

    stated: list[Columns]  # by a standard deviation of each stated number; empty ones are not felt
    inputs: list[Columns]  # by the noise of the model's inputs, drawn once more


class End(NamedTuple):
    """Where a search has ended."""

    at: Place
    jacobian: Jacobian
    effects: Effects
    iterations: int
    converged: bool


class Search:
    """A search for what a problem's columns tell.

    On a rig the gain of the flow meters and all resistances, inertances and capacitances may change together,
    and the readings stay. Derivatives that were taken a hundredth away do not know that: what they miss looks
    like a record that tells the gain.
    """

    def __init__(
        self,
        model: Model,
        rough: Model,
        problem: Problem,
        unknowns: Sequence[Unknown],
        channels: Sequence[Channel],
        progress: Callable[[], None],
        redrawn: Sequence[Model],
        stated: Sequence[Mapping[str, float]],
        near: bool = False,
        most: int | None = None,
    ) -> None:
        """Take what `output_error.fit` is given; most: steps of the search, if not `ITERATIONS`."""
        self._model, self._rough, self._problem, self._progress = model, rough, problem, progress
        self._unknowns, self._channels, self._every = unknowns, channels, range(len(unknowns))
        self._redrawn, self._stated, self._near = redrawn, stated, near
        self._most = most or ITERATIONS

    def end(self, before: Floats) -> End:
        """Return where the cost falls no further.

        Args:
            before: moves of the prior's mean by each stated number (theta, stated).
        """
        at, base, iterations = self._approached()
        taken, jacobian = at.theta, self._derivatives(at, base, self._every)
        felt, stated = at.theta, self._of_stated(at, base)
        least = self._least(at, jacobian, stated, before)
        allowed = BENT if self._rough is self._model else 0
        last, slow, fresh, converged = math.inf, 0, True, False
        while not converged and iterations < self._most:
            iterations, start = iterations + 1, at
            at = self._step(self._model, start, jacobian, least)
            if allowed and at.moved > CONVERGED:  # a shorter step tells what chance makes of it
                self._bend(jacobian, start, at)
            stale = self._is_stale(at, taken)
            ended = CONVERGED > at.moved > 0.0 or ((at.moved > 0.0 or fresh) and at.fall < LITTLE)
            converged = (ended and not stale) or (at.moved > 0.0 and at.fall < self._useless(at))
            slow += at.moved > SLOW * last
            fresh = stale or slow > allowed or at.moved == 0.0
            last, slow = (math.inf, 0) if fresh else (at.moved, slow)
            if fresh and not converged:
                taken, jacobian = at.theta, self._derivatives(at, self._base(at), self._every)
                at = at._replace(damping=DAMPING)
            elif converged and stated and self._is_stale(at, felt):
                felt, stated, converged = at.theta, self._of_stated(at, self._base(at)), False
                least = self._least(at, jacobian, stated, before)
        base = self._base(at) if self._redrawn else {}
        inputs = [self._change(model, at, base) for model in self._redrawn]
        return End(at, jacobian, Effects(stated, inputs), iterations, converged)

    def _approached(self) -> tuple[Place, dict[str, Floats], int]:
        """Return where steps of the rough model in what begins far off lead.

        With it: what the rough model predicts there, and the number of steps.
        """
        begun = [place for place in self._every if self._unknowns[place].begun]
        held = [place for place in self._every if place not in begun]
        at, steps = self._place(self._rough, self._problem.mean), 0
        taken, jacobian = at.theta, self._derivatives(at, at.predicted, begun)
        while begun and steps < self._most:
            at, steps = self._step(self._rough, at, jacobian, 0.0, held), steps + 1
            if at.fall < USELESS * self._problem.cost(at.theta, at.predicted):
                break
            if self._is_stale(at, taken):
                taken, jacobian = at.theta, self._derivatives(at, at.predicted, begun)
        if self._rough is self._model:
            return at, at.predicted, steps
        return self._place(self._model, at.theta), at.predicted, steps

    def _place(self, model: Model, theta: Floats) -> Place:
        """Return a place where a search begins."""
        predicted = self._simulate(model, theta)
        self._problem.update_noise(theta, predicted)
        return Place(theta, predicted, DAMPING, 0.0, 0.0, np.zeros(len(theta)))

    def _of_stated(self, at: Place, base: Columns) -> list[Columns]:
        """Return the effects of stated numbers at a place; base: what the rough model predicts there."""
        return [self._change(self._rough, at, base, number) if number else {} for number in self._stated]

    def _change(
        self, model: Model, at: Place, base: Columns, number: Mapping[str, float] = MappingProxyType({})
    ) -> Columns:
        """Return what another model, or another number, changes at a place."""
        moved = self._simulate(model, at.theta, number)
        return {name: moved[name] - column for name, column in base.items()}

    def _least(self, at: Place, jacobian: Jacobian, stated: list[Columns], before: Floats) -> Floats:
        """Return the standard deviations of theta that stated numbers and rounding add."""
        moved = [after(at.predicted, one) for one in stated]
        moves = self._problem.stated_effect(at.theta, at.predicted, jacobian, moved, before).slopes
        return np.asarray(np.hypot(np.sqrt(np.sum(moves**2, axis=1)), self._problem.rounded))

    def _is_stale(self, at: Place, taken: Floats) -> bool:
        """Tell whether a positive parameter is far from where derivatives were taken; others act linearly."""
        moves = np.abs(at.theta - taken) > (NEAR if self._near else np.maximum(STALE, SHARE * at.errors))
        return any(move and u.positive for move, u in zip(moves.tolist(), self._unknowns, strict=False))

    def _simulate(
        self, model: Model, theta: Floats, stated: Mapping[str, float] = MappingProxyType({})
    ) -> dict[str, Floats]:
        columns = model({**self._problem.values(theta), **stated})
        self._progress()
        return {c.name: np.asarray(columns[c.name], dtype=np.float64) for c in self._channels}

    def _base(self, at: Place) -> dict[str, Floats]:
        """Return what the rough model predicts: changes are counted from there."""
        return at.predicted if self._rough is self._model else self._simulate(self._rough, at.theta)

    def _useless(self, at: Place) -> float:
        """Return how little of the cost is not worth a step more, where the record is not explained."""
        far = any(self._problem.sigma[c.name] > FAR * c.noise for c in self._channels)
        return USELESS * self._problem.cost(at.theta, at.predicted) if far else 0.0

    def _derivatives(self, at: Place, base: dict[str, Floats], places: Collection[int]) -> dict[str, Floats]:
        """Return derivatives at a place, 0 by what is not asked for.

        Args:
            at: the place, as the exact model has it if a parameter that the model rounds is asked for.
            base: predictions of the rough model there.
            places: of the parameters.
        """
        found = {name: np.zeros((len(self._unknowns), len(column))) for name, column in base.items()}
        keys = [unknown.key for unknown in self._unknowns]
        for place in (place for place in places if self._unknowns[place].like is None):
            rounded = self._unknowns[place].rounded
            model, before = (self._model, at.predicted) if rounded else (self._rough, base)
            after, difference = self._moved(model, at.theta, place)
            for name, column in before.items():
                found[name][place] = (after[name] - column) / difference
        for place in places:
            if like := self._unknowns[place].like:
                for name, derivatives in found.items():
                    derivatives[place] = derivatives[keys.index(like[0])] - float(name == like[1])
        return found

    def _bend(self, jacobian: Jacobian, before: Place, at: Place) -> None:
        """Bend derivatives along a step (Broyden), so that they tell where it has led.

        J += (yhat(theta + d) - yhat(theta) - J d) w' / w'd,  w = d over the squares of the errors
        """
        count = len(self._unknowns)
        move = (at.theta - before.theta)[:count]
        weights = move / at.errors[:count] ** 2
        length = float(weights @ move)
        for name, derivatives in jacobian.items() if length > 0.0 else ():
            left = at.predicted[name] - before.predicted[name] - move @ derivatives
            for derivative, share in zip(derivatives, weights / length, strict=True):
                derivative += share * left

    def _moved(self, model: Model, theta: Floats, place: int) -> tuple[dict[str, Floats], float]:
        """Return what a moved parameter predicts, and its move: downwards where no machine is above."""
        moved, difference = theta.copy(), self._unknowns[place].difference
        moved[place] += difference
        try:
            return self._simulate(model, moved), difference
        except MachineError:
            moved[place] -= 2.0 * difference
            return self._simulate(model, moved), -difference

    def _step(
        self, model: Model, at: Place, jacobian: Jacobian, least: Floats | float, held: Sequence[int] = ()
    ) -> Place:
        """Return where a step leads that lowers the cost, or the same place.

        Args:
            model: that predicts.
            at: from where.
            jacobian: derivatives.
            least: standard deviations of theta that stated numbers and rounding add.
            held: places of what does not move, though its prior hangs together with what does.
        """
        problem, theta, damping = self._problem, at.theta, at.damping
        information, gradient = problem.normal(theta, at.predicted, jacobian)
        hessian = information + problem.known
        slope = gradient + problem.known @ (theta - problem.mean)
        still = np.array(held, dtype=int)
        slope[still], hessian[still], hessian[:, still], hessian[still, still] = 0.0, 0.0, 0.0, 1.0
        errors = np.hypot(np.sqrt(np.maximum(np.diag(inverse(hessian)), 1e-300)), least)
        before = problem.cost(theta, at.predicted)
        for _ in range(TRIES):
            move = damped_step(hessian, slope, damping, 1e-30, problem.reach)
            moved = float(np.max((np.abs(move) / errors)[problem.lasting], initial=1e-300))
            try:
                after = self._simulate(model, theta + move)
                fall = before - problem.cost(theta + move, after)
            except (MachineError, ValueError):
                fall = -math.inf
            if fall >= 0.0:
                problem.update_noise(theta + move, after)
                return Place(theta + move, after, damping / 10.0, moved, fall, errors)
            if moved < CONVERGED:  # chance refuses what is not worth another try
                return at._replace(moved=moved, fall=0.0, errors=errors)
            damping = max(damping, DAMPING) * (1e3 if damping < GREAT else 10.0)
        return at._replace(damping=damping, moved=0.0, fall=0.0, errors=errors)


def damped_step(
    hessian: Floats, slope: Floats, damping: float, least: float, reach: Floats | float
) -> Floats:
    """Return Marquardt's step: -(H + d diag(H + least))^-1 slope, clipped to the reach.

    Args:
        hessian: H, J'J and the prior's information.
        slope: gradient of half the cost.
        damping: d.
        least: added to the diagonal, for directions without information.
        reach: of each parameter, at most.
    """
    damped = hessian + damping * np.diag(np.diag(hessian) + least)
    return np.clip(-np.linalg.solve(damped, slope), -reach, reach)


def after(predicted: Columns, change: Columns) -> Columns:
    """Return predictions after a change; without one as they are."""
    return {name: column + change[name] if change else column for name, column in predicted.items()}
