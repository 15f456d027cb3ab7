"""What a crane may lift: its load chart, the load that is allowed over the reach."""

from dataclasses import dataclass
from itertools import pairwise

from forest_description.config.parameter import MachineError, ParameterSet, curve

MOST_POINTS = 8
"""Of a chart: compiled code needs a fixed number."""


@dataclass(frozen=True)
class LiftingCapacity(ParameterSet):
    """Allowed load over reach, straight between the points; nearer than the first point as at the first."""

    reach: tuple[float, ...] = curve("m", 0.0, 50.0, "distances of the tip from the swing axis, rising")
    load: tuple[float, ...] = curve("kg", 1.0, 1e5, "greatest load there, without the head; it never grows")

    def __post_init__(self) -> None:
        """Check ranges, that both rows belong together, and their order."""
        super().__post_init__()
        if len(self.reach) != len(self.load):
            raise MachineError(
                f"load ({len(self.load)} numbers) must have as many as reach ({len(self.reach)})"
            )
        if not 2 <= len(self.reach) <= MOST_POINTS:
            raise MachineError(f"reach has {len(self.reach)} numbers; allowed: 2 .. {MOST_POINTS}")
        if any(after <= before for before, after in pairwise(self.reach)):
            raise MachineError(f"reach ({_row(self.reach)} m) must rise from number to number")
        if any(after > before for before, after in pairwise(self.load)):
            raise MachineError(f"load ({_row(self.load)} kg) must not grow with the reach")


def _row(numbers: tuple[float, ...]) -> str:
    return ", ".join(f"{number:g}" for number in numbers)
