"""How boom and stick bend, and how the column under them twists."""

import math
from dataclasses import dataclass

from forest_description.config.parameter import MachineError, ParameterSet, parameter

LARGEST_DEFLECTION = 0.1  # [rad] that a linear spring is good for, and any crane's link stays far below


@dataclass(frozen=True)
class Elasticity(ParameterSet):
    """First bending mode of boom or stick, or twist of the column; the thesis has rigid links."""

    stiffness: float = parameter(
        "N*m/rad", 1e4, 1e12, "torque at the joint over what the link gives way; 3 E I/L of a cantilever"
    )
    damping: float = parameter("N*m*s/rad", 0.0, 1e9, "of the link's structure")
    root_inertia: float = parameter(
        "kg*m2", 1e-2, 1e5, "of what turns with the joint before the link gives way"
    )

    def require_springy(self, name: str, carried: float) -> None:
        """Raise unless what the link carries [kg m^2] swings on it; critically damped it would creep."""
        critical = 2.0 * math.sqrt(self.stiffness * carried)
        if self.damping >= critical:
            raise MachineError(
                f"{name}.damping ({self.damping:g} N*m*s/rad): the link would creep rather than swing; "
                f"allowed: below {critical:.4g} N*m*s/rad, critical for the outstretched crane on stiffness"
            )

    def require_light(self, name: str, carried: float) -> None:
        """Raise unless the root is lighter than what the link carries, itself included [kg m^2]."""
        if self.root_inertia >= carried:
            raise MachineError(
                f"{name}.root_inertia ({self.root_inertia:g} kg*m2): more than the outstretched crane has "
                f"about this joint; allowed: below {carried:.4g} kg*m2"
            )

    def require_stiff(self, name: str, torque: float, what: str) -> None:
        """Raise unless a torque [N m] deflects the link by little.

        Args:
            name: of the section.
            torque: on the joint.
            what: torque it is, in words.
        """
        deflection = torque / self.stiffness
        if deflection > LARGEST_DEFLECTION:
            raise MachineError(
                f"{name}.stiffness ({self.stiffness:g} N*m/rad): {what} ({torque:.4g} N*m) would deflect "
                f"it by {deflection:.3g} rad; allowed: at most {LARGEST_DEFLECTION:g} rad"
            )
