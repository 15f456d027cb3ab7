"""What hangs on the stick's tip besides the head's bare mass: a log in it, a joint that lets it swing.

Both are optional sections of the manipulator. A log sits still in the head. Without a pendulum,
head and log are rigid parts of the stick; with one, both hang from a passive joint with two axes at
the tip.
"""

from dataclasses import dataclass

from forest_description.config.parameter import ParameterSet, parameter


@dataclass(frozen=True)
class Log(ParameterSet):
    """A log in the head, taken as a point at its centre of mass."""

    mass: float = parameter("kg", 0.0, 1e5, "mass of the log")
    x: float = parameter(
        "m", -20.0, 20.0, "log's centre from the tip, along the stick; along the head if that is a pendulum"
    )
    y: float = parameter("m", -20.0, 20.0, "log's centre from the tip, across the stick; 0 with a pendulum")


@dataclass(frozen=True)
class Pendulum(ParameterSet):
    """Passive 2-DOF joint at the tip from which the head hangs, a body of revolution. Thesis section 4.4.

    Differs: the thesis had one on its machine and a point mass in its model.
    """

    length: float = parameter("m", 0.01, 20.0, "joint to the head's centre of mass")
    inertia: float = parameter("kg*m2", 0.0, 1e6, "head's inertia about its centre, across its axis")
    damping: float = parameter("N*m*s/rad", 0.0, 1e6, "viscous damping of each of the joint's axes")
