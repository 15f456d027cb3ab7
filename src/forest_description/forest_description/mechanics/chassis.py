"""What carries the crane: its weight, and where it stands."""

from dataclasses import dataclass

from forest_description.config.parameter import MachineError, ParameterSet, parameter


@dataclass(frozen=True)
class Chassis(ParameterSet):
    """Vehicle under the crane, on wheels or legs: it tips over the lines through these.

    Its frame is the crane's: x ahead of the swing axis, y to the left.
    """

    mass: float = parameter("kg", 1.0, 1e6, "of the vehicle without the crane")
    centre_ahead: float = parameter("m", -20.0, 20.0, "its centre of mass ahead of the swing axis")
    centre_height: float = parameter("m", 0.0, 20.0, "its centre of mass above the ground")
    pivot_height: float = parameter("m", 0.0, 20.0, "the boom's pivot above the ground")
    ahead: float = parameter("m", 0.0, 20.0, "swing axis to the line of wheels or legs ahead of it")
    behind: float = parameter("m", 0.0, 20.0, "swing axis to the line behind it")
    half_width: float = parameter("m", 0.1, 20.0, "swing axis to the lines at either side")

    def __post_init__(self) -> None:
        """Check ranges, and that the vehicle stands without the crane."""
        super().__post_init__()
        if not -self.behind < self.centre_ahead < self.ahead:
            raise MachineError(
                f"centre_ahead ({self.centre_ahead:g} m): the vehicle falls over by itself; allowed: "
                f"between {-self.behind:g} m and {self.ahead:g} m, where it stands"
            )
