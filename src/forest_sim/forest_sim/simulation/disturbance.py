"""What is done to a machine from outside: spools that are stuck, a force on the tip."""

from collections.abc import Sequence
from typing import NamedTuple

from forest_description.types import AXES, Vec3
from forest_sim.equations.plant_parameters import PlantParameters
from forest_sim.hydraulics.spool_dynamics import STUCK


class Disturbance(NamedTuple):
    """Spools that stay where they are, and the force [N] on the tip in the base frame."""

    stuck_spools: tuple[str, ...] = ()  # of `AXES`
    tip_force: Vec3 = (0.0, 0.0, 0.0)


UNDISTURBED = Disturbance()
GREATEST_FORCE = 2e5  # [N] on the tip, six times what the C-180 weighs; far above it end stops give way


def parse_stuck_spools(text: str) -> tuple[str, ...]:
    """Return the axes that a text names, separated by commas or spaces.

    Raises:
        ValueError: it names something else.
    """
    names = tuple(text.replace(",", " ").split())
    for name in names:
        if name not in AXES:
            raise ValueError(f"there is no spool '{name}'; allowed: {', '.join(AXES)}, separated by commas")
    return names


def checked_tip_force(force: Sequence[float]) -> Vec3:
    """Return the force on the tip [N] that a list gives.

    Raises:
        ValueError: it has not three numbers, or greater ones than the plant is made for.
    """
    if len(force) != 3 or not all(abs(part) <= GREATEST_FORCE for part in force):  # false for NaN as well
        raise ValueError(f"{list(force)}; allowed: 3 numbers in +-{GREATEST_FORCE:g} N")
    return force[0], force[1], force[2]


def parse_disturbance(stuck_spools: str, tip_force: Sequence[float]) -> Disturbance:
    """Return the disturbance that two node parameters name.

    Raises:
        ValueError: one of them is not usable; the text begins with its name.
    """
    try:
        stuck = parse_stuck_spools(stuck_spools)
    except ValueError as error:
        raise ValueError(f"'stuck_spools': {error}") from error
    try:
        return Disturbance(stuck, checked_tip_force(tip_force))
    except ValueError as error:
        raise ValueError(f"'tip_force' is {error}") from error


def disturbed(p: PlantParameters, disturbance: Disturbance) -> PlantParameters:
    """Return the plant under a disturbance."""
    swing, boom, stick = (
        valve._replace(lag=STUCK) if axis in disturbance.stuck_spools else valve
        for axis, valve in zip(AXES, p.valves, strict=True)
    )
    return p._replace(valves=(swing, boom, stick), tip_force=disturbance.tip_force)
