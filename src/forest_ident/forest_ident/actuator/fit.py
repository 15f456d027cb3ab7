"""Estimate the actuator's parameters from one record: output error with priors, from many starts.

    minimise  sum_n (p_n - phat_n(z))^2/(s_p^2 t_p) + sum_n (x_n - xhat_n(z))^2/(s_x^2 t_x)
              + sum_i ((z_i - m_i)/w_i)^2

| symbol | name |
|---|---|
| z | parameters, positive ones by their logarithm; m, w their priors |
| p, x | pressure and position of the record, hats: simulated freely from the valve's signal |
| s, t | size of the residuals, and their correlation length |

Residuals are correlated, because they are the model's error rather than noise: a sample counts as 1/t of one.
Gauss-Newton with Marquardt's damping; derivatives by forward differences. Where the record does not decide
between fits that explain it about as well, their mean is better than any one of them.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from forest_description.types import Bools, Floats
from forest_ident.actuator import kernel
from forest_ident.actuator.priors import PRIORS, actuator, centre
from forest_ident.output_error.search import damped_step
from forest_ident.validation.prediction_error import rms

PRESSURE_SIZE, PRESSURE_LENGTH = 0.2, 8.0  # s [P], t [n]
POSITION_SIZE, POSITION_LENGTH = 0.02, 50.0  # s [X], t [n]
ITERATIONS = 40
DIFFERENCE = 1e-4
REACH = 1.0  # of a prior's width, that one step may move
SPREAD = 0.5  # of a prior's width, by which starts differ
SIMILAR = 1.3  # of the best cost, up to which a fit counts in the mean

WIDTHS = np.array([p.width for p in PRIORS])
CENTRE = np.array(centre())


class Columns(NamedTuple):
    """A record in the units of the priors, zero at its first sample."""

    signal: Floats
    pressure: Floats
    position: Floats


class Fit(NamedTuple):
    """Result from one start."""

    z: Floats
    cost: float
    iterations: int


def simulate(z: Floats, signal: Floats, rows: int | None = None) -> tuple[Floats, Floats]:
    """Return pressures [P] and positions [X] of the actuator at z, freely from the signal [V]."""
    given = actuator(z.tolist())
    return kernel.simulate(signal, given.dead_time, given.parameters, rows)


class Problem:
    """A record, and the mask of the rows that are fitted; default: all."""

    def __init__(self, record: Columns, mask: Bools | None = None) -> None:
        self._record = record
        mask = np.ones(len(record.signal), dtype=bool) if mask is None else mask
        self._rows = int(np.flatnonzero(mask)[-1]) + 1
        self._mask = mask[: self._rows]

    def residuals(self, z: Floats) -> tuple[Floats, Floats]:
        """Return the residuals of pressure [P] and position [X] in the fitted rows."""
        pressure, position = simulate(z, self._record.signal, self._rows)
        pressure = pressure - self._record.pressure[: self._rows]
        position = position - self._record.position[: self._rows]
        return pressure[self._mask], position[self._mask]

    def weighted(self, z: Floats) -> Floats:
        """Return everything whose squares are summed, the priors last."""
        pressure, position = self.residuals(z)
        return np.concatenate(
            [
                pressure / (PRESSURE_SIZE * PRESSURE_LENGTH**0.5),
                position / (POSITION_SIZE * POSITION_LENGTH**0.5),
                (z - CENTRE) / WIDTHS,
            ]
        )

    def fitted(self, start: Floats) -> Fit:
        """Return the fit from a start."""
        z, left = start, self.weighted(start)
        cost, damping, iterations = float(left @ left), 1e-2, 0
        for iterations in range(1, ITERATIONS + 1):
            jacobian = derivatives(self.weighted, z, left) * WIDTHS
            before = cost
            for _ in range(6):
                move = damped_step(jacobian.T @ jacobian, jacobian.T @ left, damping, 1e-3, REACH)
                after = self.weighted(z + WIDTHS * move)
                if float(after @ after) < cost:
                    z, left, cost = z + WIDTHS * move, after, float(after @ after)
                    damping = max(0.25 * damping, 1e-7)
                    break
                damping *= 4.0
            if before - cost < 1e-4 * before and iterations > 5:
                break
        return Fit(z, cost, iterations)


def derivatives(of: Callable[[Floats], Floats], z: Floats, value: Floats) -> Floats:
    """Return the derivatives of a column by each parameter, by forward differences."""
    found = np.empty((len(value), len(z)))
    for i in range(len(z)):
        aside = z.copy()
        aside[i] += DIFFERENCE
        found[:, i] = (of(aside) - value) / DIFFERENCE
    return found


def fit_from_many_starts(
    problem: Problem, starts: int, seed: int = 0, progress: Callable[[int, Fit], None] = lambda _, __: None
) -> list[Fit]:
    """Return the fits from the priors' middle and from points around it, the best first.

    Thesis section 4.1.2. Differs: the thesis fits straight lines, one parameter at a time.
    """
    generator = np.random.default_rng(seed)
    found = []
    for place in range(starts):
        aside = SPREAD * WIDTHS * generator.standard_normal(len(WIDTHS)) * (place > 0)
        found.append(problem.fitted(CENTRE + aside))
        progress(place, found[-1])
    return sorted(found, key=lambda fit: fit.cost)


def similar(fits: list[Fit]) -> list[Fit]:
    """Return the fits whose cost is about that of the best."""
    return [fit for fit in fits if fit.cost <= SIMILAR * fits[0].cost]


def predicted(fits: list[Fit], signal: Floats) -> Floats:
    """Return the mean of the pressures [P] that fits simulate freely from a signal [V].

    A fit whose pressures run away under a signal that it was not fitted to does not count.
    """
    together = np.array([simulate(fit.z, signal)[0] for fit in fits])
    sound = np.max(np.abs(together), axis=1) < kernel.BEYOND
    if np.any(sound):
        together = together[sound]
    return np.asarray(together.mean(axis=0), dtype=np.float64)


def standard_errors(problem: Problem, fit: Fit) -> Floats:
    """Return the standard errors of z: H^-1 (J'W S W J + L) H^-1 with H = J'W J + L.

    W are the weights of the fit, L the priors' information, and S the residuals' covariance: a channel's
    variance e'e/(n - p) times the correlation length. So wrong weights widen the errors, if the priors are
    right.
    """
    known = np.diag(WIDTHS**-2.0)
    information, scatter = known.copy(), known.copy()
    weights = 1.0 / (PRESSURE_SIZE**2 * PRESSURE_LENGTH), 1.0 / (POSITION_SIZE**2 * POSITION_LENGTH)
    for channel, weight in enumerate(weights):

        def of(z: Floats, channel: int = channel) -> Floats:
            return problem.residuals(z)[channel]

        left = of(fit.z)
        jacobian = derivatives(of, fit.z, left)
        square = jacobian.T @ jacobian
        variance = float(left @ left) / max(len(left) - len(fit.z), 1) * correlation_length(left)
        information += weight * square
        scatter += weight * weight * variance * square
    inverse = np.linalg.inv(information)
    errors: Floats = np.sqrt(np.diag(inverse @ scatter @ inverse))
    return errors


def correlation_length(values: Floats) -> float:
    """Return the correlation length in samples: 1 + 2 sum of autocorrelations up to the first 0."""
    about = values - np.mean(values)
    power = float(about @ about)
    length = 1.0
    for lag in range(1, len(about) // 2):
        share = float(about[:-lag] @ about[lag:]) / power if power > 0.0 else 0.0
        if share <= 0.0:
            break
        length += 2.0 * share
    return length


class Fold(NamedTuple):
    """Rows fitted, rows predicted, RMS of pressure over each [P], of the mean over similar fits."""

    fitted: tuple[int, int]
    held_out: tuple[int, int]
    rms_fitted: float
    rms_held_out: float


FOLDS = (  # shares of a record that are fitted, and held out
    ((0.0, 0.557), (0.557, 1.0)),
    ((0.0, 0.713), (0.713, 1.0)),
    ((0.4, 1.0), (0.0, 0.4)),
    ((0.0, 0.84), (0.84, 1.0)),
)


def cross_validated(
    record: Columns, starts: int, progress: Callable[[str], None] = lambda _: None
) -> list[Fold]:
    """Return how well parts of a record are predicted by fits to the other part."""
    found = []
    for shares, held in FOLDS:
        count = len(record.signal)
        a, b = round(shares[0] * count), round(shares[1] * count)
        c, d = round(held[0] * count), round(held[1] * count)
        mask = np.zeros(count, dtype=bool)
        mask[a:b] = True
        progress(f"cross-validation: rows {a} to {b - 1}")
        fits = similar(fit_from_many_starts(Problem(record, mask), starts))
        error = predicted(fits, record.signal) - record.pressure
        found.append(Fold((a, b), (c, d), rms(error[a:b]), rms(error[c:d])))
    return found
