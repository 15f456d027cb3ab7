"""Whether a fit can be trusted, by what its residuals, its intervals and held-out records say.

| verdict | when |
|---|---|
| trusted | every record is explained, every estimate is told by the data, held-out records are predicted |
| trusted but for | the same, but for some parameters: each with its reason |
| not trusted | a held-out record is missed, or one contradicts all others, or most intervals are withheld |
| not trusted | no residual was tested |
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from forest_ident.refinement.result import Result
from forest_ident.validation.prediction_error import Signal, over_limit

TRUSTED, BUT_FOR, NOT_TRUSTED = 0, 3, 4
"""Exit codes."""
VALIDATION = "validation"
"""The experiment that is there to judge by; other motions that are held out may hold nothing."""
MOST = 0.5  # of the estimates
CORRELATED = 0.2  # at the sensor's lag 1
LEFT = 1.5  # times a sensor's noise: correlated residuals of more are the model's
ASKED = 5.0  # standard deviations of a stated number: who told it is not that far off


class Verdict(NamedTuple):
    """How far a fit can be trusted."""

    code: int
    reasons: tuple[str, ...]  # of the whole
    doubts: dict[str, str]  # reason by parameter

    @property
    def lines(self) -> list[str]:
        """The verdict as text, its first line alone the answer."""
        if self.code == TRUSTED:
            return ["trusted"]
        head = "not trusted" if self.code == NOT_TRUSTED else f"trusted but for {', '.join(self.doubts)}"
        return [head, *self.reasons, *(f"{key}: {reason}" for key, reason in self.doubts.items())]


def verdict(result: Result, held_out: Sequence[tuple[str, Sequence[Signal]]] = ()) -> Verdict:
    """Return the verdict on a fit.

    Args:
        result: of the identification.
        held_out: record and the signals that were predicted with it, none if it cannot be.
    """
    doubts = _doubts(result)
    reasons = [f"{name}: {text}" for name, signals in held_out for text in over_limit(signals)]
    blind = [name for name, signals in held_out if name == VALIDATION and not signals]
    reasons += [f"{name}: held out, but it cannot be predicted" for name in blind]
    if result.estimates and not result.refined:
        reasons.append("linear estimates alone: no residual was tested")
    if result.stranger:
        reasons.append(
            f"{result.stranger}: it alone is not explained, the other records agree with each other"
        )
    withheld = sum(e.withheld for e in result.estimates.values())
    if withheld > MOST * len(result.estimates):
        reasons.append(
            f"{withheld} of {len(result.estimates)} intervals are withheld: the model lacks something"
        )
    code = NOT_TRUSTED if reasons else BUT_FOR if doubts else TRUSTED
    return Verdict(code, tuple(reasons), doubts)


def _doubts(result: Result) -> dict[str, str]:
    """Return the reason of doubt of each doubtful parameter; the first counts."""
    pairs = [(key, "its estimate is impossible") for key in result.impossible]
    pairs += [
        (key, f"the refinement of {name} failed") for name, keys in result.failed.items() for key in keys
    ]
    pairs += [
        (e.key, "interval withheld, its record is not explained")
        for e in result.estimates.values()
        if e.withheld
    ]
    pairs += [(e.key, e.warning) for e in result.estimates.values() if e.warning]
    pairs += [
        (key, f"the search of {r.session.name} was broken off after {r.fit.iterations} steps")
        for r in result.refined
        if not r.fit.converged
        for key in r.free
    ]
    for r in result.refined:
        far, number = max(zip(np.abs(r.fit.asked).tolist(), result.stated, strict=False), default=(0.0, ""))
        if far > ASKED:
            said = (
                f"what is left of {r.session.name} asks for {number} {far:.0f} standard deviations from what "
                "is told: told numbers are wrong, the search ended in a wrong place, or the model lacks "
                "something; its interval holds none of that"
            )
            pairs += [(key, said) for key in r.free]
        odd = [t for t in r.tests if t.times > LEFT and (t.correlation or 0.0) > CORRELATED]
        if odd:
            worst = max(odd, key=lambda test: test.times)
            said = (
                f"interval widened, residuals of {r.session.name} are {worst.times:.1f} times the noise of "
                f"{worst.channel} and correlated ({worst.correlation:.2f})"
            )
            pairs += [(key, said) for key in r.free]
    return dict(reversed(pairs))
