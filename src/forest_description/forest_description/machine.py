"""The crane as numbers: pump, valve, hoses, actuators, manipulator, sensors; all SI, frozen, range-checked.

``load_machine("c180")`` reads a shipped machine, ``load_machine("my_crane.yaml")`` a file of one's
own. Axes are numbered 0 swing, 1 boom, 2 stick. Port 1 drives the positive direction (swing left;
cylinder's head side, extending), port 2 the negative one. Where every shipped number comes from:
``python -m forest_description.export.machine_numbers`` (docs/reference/machine.md).
"""

import functools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from forest_description.config import schema, source_tree
from forest_description.config.parameter import MachineError, ParameterSet, parameter
from forest_description.config.units import UNITS
from forest_description.geometry.linkage import Linkage
from forest_description.hydraulics.hose import GeometricHose, Hose, Line, MeasuredHose
from forest_description.hydraulics.load_holding_parameters import CounterbalanceValve, RuptureValve
from forest_description.hydraulics.oil import Oil
from forest_description.hydraulics.pump import IdealPump, LoadSensingPump, Pump
from forest_description.hydraulics.tank_line_parameters import TankLine
from forest_description.hydraulics.valve_parameters import PortValves, Valve
from forest_description.mechanics.chassis import Chassis
from forest_description.mechanics.drives import CylinderDrive, SwingDrive
from forest_description.mechanics.end_stops import EndStops
from forest_description.mechanics.lifting_capacity import LiftingCapacity
from forest_description.mechanics.manipulator_parameters import Manipulator
from forest_description.sensors.sensor_kinds import Sensors
from forest_description.types import AXES

OWN_SECTIONS = ("valve", "hose")
"""What an axis may have of its own instead of what all share."""
ROUNDING = 1e-3  # [m] of a reach, as its complaint has it


class _Part(NamedTuple):
    """What an outstretched crane carries: mass [kg], distance from a joint [m], inertia [kg m^2]."""

    mass: float
    distance: float
    inertia: float


def _farther(parts: tuple[_Part, ...], by: float) -> tuple[_Part, ...]:
    """Return parts as seen from a joint farther in by a length [m]."""
    return tuple(part._replace(distance=part.distance + by) for part in parts)


def _moment(parts: tuple[_Part, ...], m: Manipulator) -> float:
    """Return the moment [N m] of parts' weights about their joint."""
    return m.gravity * sum(part.mass * part.distance for part in parts)


def _carried(parts: tuple[_Part, ...]) -> float:
    """Return the inertia [kg m^2] of parts about their joint."""
    return sum(part.inertia + part.mass * part.distance**2 for part in parts)


@dataclass(frozen=True)
class Machine(ParameterSet):
    """A whole crane. A component that is None is not there."""

    name: str
    description: str
    pump: Pump
    valve: Valve
    hose: Hose
    oil: Oil | None
    swing: SwingDrive
    boom: CylinderDrive
    stick: CylinderDrive
    manipulator: Manipulator
    sensors: Sensors
    port_valves: PortValves | None
    end_stops: EndStops | None
    command_timeout: float = parameter("s", 0.005, 10.0, "age at which a voltage command counts as zero")
    tank_line: TankLine | None = None
    capacity: LiftingCapacity | None = None
    chassis: Chassis | None = None

    def __post_init__(self) -> None:
        """Check ranges, where the joints go, the port valves, and what hoses known by their bore need."""
        super().__post_init__()
        if not self.name.isprintable() or not self.name or {"/", "\\"} & set(self.name):
            raise MachineError(
                f"name ({self.name!r}): files are named by it; allowed: printable characters but / and \\"
            )
        self._check_joints()
        valves, supply = self.port_valves, self.pump.supply_pressure
        if valves is not None and valves.relief_pressure < supply:
            raise MachineError(
                f"port_valves.relief_pressure ({valves.relief_pressure:g} Pa) must not be below "
                f"pump.supply_pressure ({supply:g} Pa): every port would pass the pump's oil to the tank"
            )
        self._check_bearing()
        self._check_jets()
        self._check_tank_line()
        self._check_elasticity()
        self._check_capacity()
        for axis, name in enumerate(AXES):
            drive = self.drives[axis]
            if drive.chambers is not None and self.oil is None:
                raise MachineError(
                    f"oil is null, but the {name} has chambers: how their oil yields needs its bulk_modulus"
                )
            self._check_holding(name, drive)
            self._check_compensator("valve" if drive.valve is None else f"{name}.valve", self.valve_of(axis))
            if not isinstance(self.hose_of(axis), GeometricHose):
                continue
            if self.oil is None:
                raise MachineError(
                    f"oil is null, but the {name}'s hose is geometric: its numbers need an oil"
                )
            if drive.length_exponent != 1.0:
                raise MachineError(
                    f"{name}.length_exponent ({drive.length_exponent:g}) must be 1 with a geometric hose: "
                    "there is no measured length to go by"
                )

    def _check_tank_line(self) -> None:
        """Raise if the tank line takes all of the pump's pressure."""
        line, pump = self.tank_line, self.pump
        if line is None:
            return
        flow = 0.0 if isinstance(pump, IdealPump) else pump.flow_limit
        taken = line.preload + line.resistance * flow**2
        if taken >= pump.supply_pressure:
            raise MachineError(
                f"tank_line.resistance ({line.resistance:g} Pa*s2/m6) takes {taken:g} Pa at the pump's full "
                f"flow, with its preload; allowed: less than pump.supply_pressure "
                f"({pump.supply_pressure:g} Pa)"
            )

    def _check_capacity(self) -> None:
        """Raise unless the load chart goes as far as the crane reaches."""
        m, chart = self.manipulator, self.capacity
        reach = m.base_offset + m.boom_length + m.stick_length
        if chart is not None and chart.reach[-1] < reach - ROUNDING:
            raise MachineError(
                f"capacity.reach ends at {chart.reach[-1]:g} m; allowed: at least {reach:.3f} m, "
                f"as far as straight links reach"
            )

    def _check_holding(self, name: str, drive: SwingDrive | CylinderDrive) -> None:
        """Raise if a load-holding valve has no oil of its own behind it, or if no pressure pilots it open."""
        for port, valve in (("holding_1", drive.holding_1), ("holding_2", drive.holding_2)):
            if valve is not None and drive.chambers is None:
                raise MachineError(
                    f"{name}.chambers is null, but {name}.{port} holds the oil in them; allowed: both, or "
                    f"neither"
                )
            if valve is None or isinstance(valve, RuptureValve):
                continue
            balance = drive.area_ratio if port == "holding_1" else 1.0 / drive.area_ratio
            helped = balance if isinstance(valve, CounterbalanceValve) else -balance
            least = valve.setting / self.pump.supply_pressure - helped
            if valve.pilot_ratio <= least:
                raise MachineError(
                    f"{name}.{port}.setting ({valve.setting:g} Pa): without a load the pump's full pressure "
                    f"on the other side does not open it with {name}.{port}.pilot_ratio "
                    f"({valve.pilot_ratio:g}); allowed: a pilot_ratio above {least:.4g}, or a lower setting"
                )

    def _check_compensator(self, where: str, valve: Valve) -> None:
        """Raise unless the pump leaves a compensator the pressure that it works with."""
        given, pump = valve.compensator, self.pump
        if given is None:
            return
        if valve.deadband_voltage < 0.0 or (valve.backward and valve.backward.deadband_voltage < 0.0):
            raise MachineError(
                f"{where}.deadband_voltage ({valve.deadband_voltage:g} V): a valve with a compensator must "
                f"not be underlapped; allowed: at least 0 V, backward too"
            )
        flow = 0.0 if isinstance(pump, IdealPump) else pump.flow_limit
        taken = given.minimum_resistance * flow**2
        if taken >= pump.supply_pressure:
            raise MachineError(
                f"{where}.compensator.minimum_resistance ({given.minimum_resistance:g} Pa*s2/m6) takes "
                f"{taken:g} Pa at the pump's full flow; allowed: less than pump.supply_pressure "
                f"({pump.supply_pressure:g} Pa)"
            )
        if isinstance(pump, LoadSensingPump):
            used = given.setting + (given.control_range if given.kind == "after_spool" else 0.0)
            if used >= pump.margin:
                raise MachineError(
                    f"{where}.compensator.setting ({given.setting:g} Pa): the compensator uses {used:g} Pa "
                    f"of pump.margin ({pump.margin:g} Pa); allowed: less than that"
                )
        elif given.kind == "after_spool":
            raise MachineError(
                f"{where}.compensator.kind = after_spool shares what a load-sensing pump leaves over the "
                f"greatest load; allowed: before_spool, or pump.kind load_sensing"
            )

    def _check_jets(self) -> None:
        """Raise unless springs hold the spools that flow forces push, in oil of a known density."""
        for axis, name in enumerate(AXES):
            valve = self.valve_of(axis)
            if valve.centring_force is None:
                continue
            key = "valve" if valve is self.valve else f"{name}.valve"
            if self.oil is None:
                raise MachineError(f"oil is null, but {key}.centring_force needs its density")
            least = 2.0 * valve.jet_stiffness(self.pump.supply_pressure, self.oil.density)
            if valve.centring_force <= least:
                raise MachineError(
                    f"{key}.centring_force ({valve.centring_force:g} N/V): at pump.supply_pressure the flow "
                    f"forces would take half of the spool's stroke or more; allowed: above {least:g} N/V"
                )

    def _check_bearing(self) -> None:
        """Raise unless the swing's motor can break its bearing away."""
        friction = self.swing.friction
        most = self.swing.gear_ratio * self.swing.motor_displacement * self.pump.supply_pressure
        if friction is not None and friction.breakaway_torque >= most:
            raise MachineError(
                f"swing.friction.breakaway_torque ({friction.breakaway_torque:g} N*m) must be smaller than "
                f"what the motor has at pump.supply_pressure ({most:g} N*m): the swing would never turn"
            )

    def _check_elasticity(self) -> None:
        """Raise unless links give way by little under weight and motor, and the motor suits its gear."""
        m = self.manipulator
        stick = _Part(m.stick_mass, abs(m.stick_x), m.stick_zz), _Part(m.head_mass, m.stick_length, 0.0)
        boom = _Part(m.boom_mass, abs(m.boom_x), m.boom_zz), *_farther(stick, m.boom_length)
        whole = _Part(m.base_mass, abs(m.base_x), m.base_zz), *_farther(boom, m.base_offset)
        motor = self.swing.gear_ratio * self.swing.motor_displacement * self.pump.supply_pressure
        for name, link, parts, torque, of in (
            ("swing", self.swing.elasticity, whole, motor, "the motor at pump.supply_pressure"),
            ("boom", self.boom.elasticity, boom, _moment(boom, m), "the outstretched crane's weight"),
            ("stick", self.stick.elasticity, stick, _moment(stick, m), "the level stick's weight"),
        ):
            if link is not None:
                link.require_stiff(f"{name}.elasticity", torque, of)
                link.require_light(f"{name}.elasticity", _carried(parts))
                link.require_springy(f"{name}.elasticity", _carried(parts))
        if self.swing.backlash is not None:
            self.swing.backlash.require_strikes(_carried(whole), self.swing.gear_ratio)

    def _check_joints(self) -> None:
        """Raise unless boom and stick go where the kinematics are made for."""
        low, high = self.boom.angles
        if not -math.pi <= low < high <= math.pi:
            raise MachineError(
                f"boom.angle_offset: over the stroke the boom goes from {math.degrees(low):.1f} to "
                f"{math.degrees(high):.1f} deg; allowed: within -180 .. 180 deg (0 level, positive raised)"
            )
        low, high = self.stick.angles
        if not (low < 0.0 and high > -math.pi):
            raise MachineError(
                f"stick.angle_offset: over the stroke the stick goes from {math.degrees(low):.1f} to "
                f"{math.degrees(high):.1f} deg; allowed: some of -180 .. 0 deg (0 straight, negative folded)"
            )

    @property
    def drives(self) -> tuple[SwingDrive, CylinderDrive, CylinderDrive]:
        """Drives of swing, boom and stick."""
        return (self.swing, self.boom, self.stick)

    @property
    def linkages(self) -> tuple[Linkage, Linkage]:
        """Cylinder linkages of boom and stick."""
        return (self.boom.linkage, self.stick.linkage)

    def line(self, axis: int, port: int) -> Line:
        """Return the hose between a valve and an actuator port. Thesis section 3.2.3.

        Args:
            axis: 0 swing, 1 boom, 2 stick.
            port: 1 or 2.

        Raises:
            ValueError: There is no such axis or port.
        """
        length, drive, hose = self.line_length(axis, port), self.drives[axis], self.hose_of(axis)
        laminar = drive.flow_regime == "laminar"
        if isinstance(hose, MeasuredHose):
            return hose.line(length, drive.length_exponent, laminar)
        assert self.oil is not None  # __post_init__ saw to it
        return hose.line(length, laminar, self.oil)

    def line_length(self, axis: int, port: int) -> float:
        """Return the length [m] of the hose between a valve and an actuator port; arguments as ``line``."""
        if axis not in (0, 1, 2) or port not in (1, 2):
            raise ValueError(f"axis {axis}, port {port}: axes are 0, 1, 2 and ports 1, 2")
        drive = self.drives[axis]
        return drive.line_1_length if port == 1 else drive.line_2_length

    def valve_of(self, axis: int) -> Valve:
        """Return the valve of an axis: its own, or else the one that all share.

        Args:
            axis: 0 swing, 1 boom, 2 stick.
        """
        return self.drives[axis].valve or self.valve

    def hose_of(self, axis: int) -> Hose:
        """Return the hose of an axis: its own, or else the one that all share; axis as ``valve_of``."""
        return self.drives[axis].hose or self.hose

    def demand_resolvers(self, who: str) -> None:
        """Refuse a machine whose boom and stick have no resolvers, for who knows no other angles' errors.

        Raises:
            MachineError: they have none.
        """
        if not self.sensors.by_resolvers:
            raise MachineError(
                f"{self.name} has the angles of boom and stick by its {self.sensors.joint_angles}; "
                f"allowed: a crane with resolvers: {who} knows no other angles' errors"
            )


def load_machine(name_or_path: str | Path = "c180") -> Machine:
    """Return a machine: a shipped one by its name, as "c180" or "forwarder", a drawn one, or a YAML file's.

    Args:
        name_or_path: A name without suffix looks up a shipped machine; "unknown:7" draws one
            (`forest_description.config.random_machine`); anything else is a file.

    Raises:
        MachineError: The file is not usable; the message has file, line, key, value and what is
            allowed.
    """
    name = str(name_or_path)
    return _shipped(name) if source_tree.is_shipped(name) else schema.build(Machine, _read(name_or_path))


@functools.lru_cache(maxsize=32)
def _shipped(name: str) -> Machine:
    """Return a machine that comes with the package: its files do not change, and it cannot be changed."""
    return schema.build(Machine, _read(name))


def _read(name_or_path: str | Path) -> source_tree.Branch:
    """Return a machine's tree; an axis' own valve or hose gives what differs from the shared one."""
    tree = source_tree.read(name_or_path)
    for section in OWN_SECTIONS:
        shared = tree.children.get(section)
        for axis in AXES:
            drive = tree.children.get(axis)
            if not (isinstance(drive, source_tree.Branch) and isinstance(shared, source_tree.Branch)):
                continue
            own = drive.children.get(section)
            if isinstance(own, source_tree.Branch):
                drive.children[section] = source_tree.overlay(shared, own)
    return tree


def sources(name_or_path: str | Path = "c180") -> list[schema.Quantity]:
    """Return key, value, unit, source and uncertainty of every number, in the file's own units.

    Raises:
        MachineError: As ``load_machine``.
    """
    load_machine(name_or_path)  # so that an unusable file gets its message here, too
    return schema.quantities(Machine, _read(name_or_path))


def uncertainties(name_or_path: str | Path = "c180") -> dict[str, float]:
    """Return the half-widths [SI] of the 95 % intervals that a machine's file states, by dotted key.

    Raises:
        MachineError: As ``load_machine``.
    """
    stated = ((row.key, row.uncertainty, row.unit) for row in sources(name_or_path))
    return {key: half * UNITS[unit].factor for key, half, unit in stated if half is not None}
