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

from forest_ident.refinement.result import Result
from forest_ident.validation.prediction_error import Signal, over_limit

TRUSTED, BUT_FOR, NOT_TRUSTED = 0, 3, 4
"""Exit codes."""
VALIDATION = "validation"
"""The experiment that is there to judge by; other motions that are held out may hold nothing."""
MOST = 0.5  # of the estimates


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
    stated = result.told.keys() - result.estimates.keys()
    pairs += [(key, doubt.reason) for doubt in result.doubts for key in doubt.keys if key not in stated]
    return dict(reversed(pairs))
