"""The actuators of a crane: swing motor with its gear train, boom and stick cylinders with their linkages."""

import math
from dataclasses import dataclass

from forest_description.config.parameter import (
    MachineError,
    ParameterSet,
    choice,
    component,
    optional_parameter,
    parameter,
    require_order,
)
from forest_description.geometry.linkage import Linkage, joint_angle, linkage_of
from forest_description.hydraulics.hose import Hose
from forest_description.hydraulics.load_holding_parameters import LoadHolding
from forest_description.hydraulics.valve_parameters import Valve
from forest_description.mechanics.elasticity_parameters import Elasticity

LONGEST_STUCK = 0.01  # [rad] that a bearing gives way before it slides; rolling bearings give under 1e-3
CREEPING = 10.0  # times critical damping: so damped teeth close over many of their own periods


@dataclass(frozen=True)
class Friction(ParameterSet):
    """Dry friction of a cylinder's seals with the Stribeck effect; the thesis has viscous friction alone."""

    coulomb_force: float = parameter("N", 0.0, 1e7, "friction at speed")
    breakaway_force: float = parameter("N", 0.0, 1e7, "friction just before it slides")
    stribeck_speed: float = parameter("m/s", 1e-5, 1.0, "over which breakaway falls to coulomb friction")
    smoothing_speed: float = parameter("m/s", 1e-6, 0.1, "under which friction goes through zero smoothly")
    pressure_coefficient: float | None = optional_parameter(
        "N/Pa", 1e-8, 1.0, "more coulomb friction per pressure of both chambers together"
    )

    def __post_init__(self) -> None:
        """Check ranges, that breaking away is no easier than sliding, and that its peak shows."""
        super().__post_init__()
        if self.pressure_coefficient is not None and self.coulomb_force == 0.0:
            raise MachineError(
                "pressure_coefficient is of seals that pressure adds to; allowed: a coulomb_force above 0 N"
            )
        _require_peak("force", self.coulomb_force, self.breakaway_force, "N")
        if self.breakaway_force > self.coulomb_force:
            smoothed, falls = self.smoothing_speed, self.stribeck_speed
            require_order("smoothing_speed", smoothed, "stribeck_speed", falls, "m/s")


@dataclass(frozen=True)
class BearingFriction(ParameterSet):
    """Dry friction of the swing's bearing and seals, which sticks; the thesis has viscous friction alone."""

    coulomb_torque: float = parameter("N*m", 1.0, 1e7, "friction at speed")
    breakaway_torque: float = parameter("N*m", 1.0, 1e7, "friction just before it slides")
    stribeck_speed: float = parameter("rad/s", 1e-5, 1.0, "over which breakaway falls to coulomb friction")
    stiffness: float = parameter("N*m/rad", 1e4, 1e12, "of the bristles that stick")
    damping: float = parameter("N*m*s/rad", 0.0, 1e9, "of the bristles that stick")
    elastic_share: float = parameter(
        "1", 0.0, 0.99, "of the coulomb torque, up to which bristles only bend; above it they yield, too"
    )

    def __post_init__(self) -> None:
        """Check ranges, that breaking away is no easier than sliding, and that it takes no long way."""
        super().__post_init__()
        _require_peak("torque", self.coulomb_torque, self.breakaway_torque, "N*m")
        way = self.breakaway_torque / self.stiffness
        if way > LONGEST_STUCK:
            raise MachineError(
                f"stiffness ({self.stiffness:g} N*m/rad): the bearing would turn {way:g} rad before it "
                f"breaks away; allowed: at most {LONGEST_STUCK:g} rad"
            )


def _require_peak(of: str, coulomb: float, breakaway: float, unit: str) -> None:
    """Raise unless breaking away takes as much as sliding does."""
    if breakaway < coulomb:
        raise MachineError(
            f"breakaway_{of} ({breakaway:g} {unit}) must not be below coulomb_{of} ({coulomb:g} {unit})"
        )


@dataclass(frozen=True)
class Backlash(ParameterSet):
    """Play of the swing's gear, and the motor that it lets go; the thesis has a gear without."""

    free_way: float = parameter("rad", 1e-6, 0.1, "of the joint between its teeth with the motor held, 2 b")
    motor_inertia: float = parameter("kg*m2", 1e-6, 10.0, "of the motor and what turns with it, at its shaft")
    stiffness: float = parameter("N*m/rad", 1e4, 1e11, "of teeth and gear, seen at the joint")
    damping: float = parameter("N*m*s/rad", 0.0, 1e9, "of the teeth in contact, seen at the joint")

    def require_strikes(self, carried: float, gear_ratio: float) -> None:
        """Raise unless the motor is lighter than the crane [kg m^2], and strikes its teeth."""
        motor = self.motor_inertia * gear_ratio**2
        if motor >= carried:
            raise MachineError(
                f"swing.backlash.motor_inertia ({self.motor_inertia:g} kg*m2): through the gear more than "
                f"the outstretched crane has; allowed: below {carried / gear_ratio**2:.4g} kg*m2"
            )
        most = CREEPING * 2.0 * math.sqrt(self.stiffness * motor)
        if self.damping >= most:
            raise MachineError(
                f"swing.backlash.damping ({self.damping:g} N*m*s/rad): the motor would creep on its teeth "
                f"rather than strike them; allowed: below {most:.4g} N*m*s/rad, {CREEPING:g} times critical"
            )


@dataclass(frozen=True)
class Cushion(ParameterSet):
    """Throttle at both ends of a cylinder's stroke that brakes the piston before it meets the stop."""

    length: float = parameter("m", 1e-3, 1.0, "stroke over which a cushion works, before each end")
    resistance: float = parameter("N*s2/m2", 0.0, 1e12, "braking force per squared speed at the very end")


@dataclass(frozen=True)
class CylinderChambers(ParameterSet):
    """Oil in a cylinder on both sides of its piston, which yields with it; the thesis leaves it out."""

    head_dead_volume: float = parameter(
        "m3", 1e-6, 0.1, "oil on the head side with the cylinder retracted, ports and pipes included"
    )
    rod_dead_volume: float = parameter(
        "m3", 1e-6, 0.1, "oil on the rod side with the cylinder extended, ports and pipes included"
    )


@dataclass(frozen=True)
class MotorChambers(ParameterSet):
    """Oil in the swing motor on each side, which yields; the thesis leaves it out."""

    port_volume: float = parameter(
        "m3", 1e-7, 0.01, "oil of one port: half of the chambers, galleries and pipes"
    )


@dataclass(frozen=True)
class SwingDrive(ParameterSet):
    """Hydraulic motor and gear train of the swing. Thesis section 3.2.5, 3.3."""

    motor_displacement: float = parameter(
        "m3/rad", 1e-8, 1e-3, "displacement D_m of the motor, per turn of its shaft"
    )
    gear_ratio: float = parameter("1", 1.0, 1e4, "N, motor speed over swing speed")
    internal_leakage_resistance: float = parameter("Pa*s/m3", 1e9, 1e18, "R_in between the motor's ports")
    external_leakage_resistance: float = parameter("Pa*s/m3", 1e9, 1e18, "R_e of each port to the case drain")
    damping: float = parameter("N*m*s/rad", 0.0, 1e7, "viscous damping B_sw at the swing joint")
    line_1_length: float = parameter("m", 0.05, 100.0, "hose from valve to port 1")
    line_2_length: float = parameter("m", 0.05, 100.0, "hose from valve to port 2")
    length_exponent: float = parameter("1", 1.0, 2.0, "power of length in hose inertance and capacitance")
    flow_regime: str = choice("laminar", "turbulent", doc="flow in the hoses")
    valve: Valve | None = component()
    hose: Hose | None = component()
    lower_limit: float = parameter("rad", -20.0, 20.0, "smallest swing angle")
    upper_limit: float = parameter("rad", -20.0, 20.0, "largest swing angle")
    chambers: MotorChambers | None = None  # may be left out
    friction: BearingFriction | None = None  # may be left out
    backlash: Backlash | None = None  # may be left out
    holding_1: LoadHolding | None = None
    holding_2: LoadHolding | None = None
    elasticity: Elasticity | None = None

    def __post_init__(self) -> None:
        """Check ranges, and that the swing has room to move, past its gear's play too."""
        super().__post_init__()
        require_order("lower_limit", self.lower_limit, "upper_limit", self.upper_limit, "rad")
        if self.backlash is not None:
            travel = self.upper_limit - self.lower_limit
            require_order("backlash.free_way", self.backlash.free_way, "the swing's travel", travel, "rad")

    @property
    def area_ratio(self) -> float:
        """Pressure [1] that keeps port 1 in balance, without a load, over port 2's."""
        return 1.0


@dataclass(frozen=True)
class CylinderDrive(ParameterSet):
    """Single-ended cylinder of boom or stick with its linkage. Thesis section 3.2.4, App. A."""

    head_area: float = parameter("m2", 1e-5, 1.0, "piston area on the head side, gy1 (port 1)")
    rod_area: float = parameter("m2", 1e-5, 1.0, "piston area on the rod side, gy2 (port 2)")
    damping: float = parameter("N*s/m", 0.0, 1e8, "viscous friction B of the cylinder")
    retracted_length: float = parameter("m", 0.1, 10.0, "pin-to-pin length, fully retracted")
    stroke: float = parameter("m", 0.01, 10.0, "stroke")
    pivot_to_base: float = parameter("m", 0.01, 10.0, "joint to the cylinder's pivot")
    pivot_to_rod: float = parameter("m", 0.01, 10.0, "joint to the rod's pivot")
    angle_offset: float = parameter("rad", -7.0, 7.0, "triangle's angle at the joint, at joint angle 0")
    line_1_length: float = parameter("m", 0.05, 100.0, "hose from valve to head side")
    line_2_length: float = parameter("m", 0.05, 100.0, "hose from valve to rod side")
    length_exponent: float = parameter("1", 1.0, 2.0, "power of length in hose inertance and capacitance")
    flow_regime: str = choice("laminar", "turbulent", doc="flow in the hoses")
    valve: Valve | None = component()
    hose: Hose | None = component()
    friction: Friction | None = component()
    cushion: Cushion | None = component()
    chambers: CylinderChambers | None = None  # may be left out
    holding_1: LoadHolding | None = None
    holding_2: LoadHolding | None = None
    elasticity: Elasticity | None = None

    def __post_init__(self) -> None:
        """Check ranges, the areas, that rod and linkage allow the stroke, and that cushions fit in it."""
        super().__post_init__()
        require_order("rod_area", self.rod_area, "head_area", self.head_area, "m2")
        shortest, longest = self.retracted_length, self.retracted_length + self.stroke
        a, b = self.pivot_to_base, self.pivot_to_rod
        if not abs(a - b) < shortest < longest < a + b:
            raise MachineError(
                f"retracted_length, stroke: the cylinder goes from {shortest:g} to {longest:g} m, "
                f"the linkage closes only between {abs(a - b):g} and {a + b:g} m"
            )
        require_order("stroke", self.stroke, "retracted_length", self.retracted_length, "m")
        self._check_chambers()
        self._check_seals()
        if self.cushion is not None and self.cushion.length > 0.5 * self.stroke:
            raise MachineError(
                f"cushion.length ({self.cushion.length:g} m) must be at most half the stroke "
                f"({0.5 * self.stroke:g} m)"
            )

    def _check_seals(self) -> None:
        """Raise unless a piston moves whose rod side alone is pressed, against the seals' breakaway."""
        if self.friction is None or self.friction.pressure_coefficient is None:
            return
        most = self.rod_area * self.friction.coulomb_force / self.friction.breakaway_force
        if self.friction.pressure_coefficient >= most:
            raise MachineError(
                f"friction.pressure_coefficient ({self.friction.pressure_coefficient:g} N/Pa): at any "
                f"pressure the seals would hold the rod side's piston; allowed: below {most:g} N/Pa, "
                f"rod_area times coulomb_force over breakaway_force"
            )

    def _check_chambers(self) -> None:
        """Raise unless dead volumes are small beside what the stroke sweeps."""
        if self.chambers is None:
            return
        for side, area in (("head", self.head_area), ("rod", self.rod_area)):
            dead, swept = getattr(self.chambers, f"{side}_dead_volume"), area * self.stroke
            if dead > swept:
                raise MachineError(
                    f"chambers.{side}_dead_volume ({dead:g} m3) must be at most what the stroke sweeps "
                    f"({swept:g} m3)"
                )

    @property
    def angles(self) -> tuple[float, float]:
        """Joint angles [rad] with the cylinder retracted and extended."""
        ends = (self.retracted_length, self.retracted_length + self.stroke)
        return joint_angle(ends[0], self.linkage), joint_angle(ends[1], self.linkage)

    @property
    def area_ratio(self) -> float:
        """Pressure [1] that keeps port 1 in balance, without a load, over port 2's."""
        return self.rod_area / self.head_area

    @property
    def linkage(self) -> Linkage:
        """The constants of ``linkage.py``'s functions."""
        return linkage_of(self.pivot_to_base, self.pivot_to_rod, self.angle_offset)
