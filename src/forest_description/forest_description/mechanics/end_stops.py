"""What stops joints at the ends of their ways."""

from dataclasses import dataclass

from forest_description.config.parameter import ParameterSet, parameter


@dataclass(frozen=True)
class EndStops(ParameterSet):
    """Spring and damper at the ends of strokes and of the swing; not in the thesis."""

    cylinder_stiffness: float = parameter("N/m", 1e5, 1e11, "stiffness of a cylinder's end stop")
    cylinder_damping: float = parameter("N*s/m", 0.0, 1e9, "damping of a cylinder's end stop")
    swing_stiffness: float = parameter("N*m/rad", 1e4, 1e11, "stiffness of the swing's end stop")
    swing_damping: float = parameter("N*m*s/rad", 0.0, 1e9, "damping of the swing's end stop")
