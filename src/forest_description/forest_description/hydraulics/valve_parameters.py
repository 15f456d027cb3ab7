"""The parameters of the valves that the axes of a machine share: the spool valve, and the port valves."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, cast

import numpy as np

from forest_description.config.parameter import (
    MachineError,
    ParameterSet,
    choice,
    component,
    curve,
    optional_parameter,
    parameter,
    require_order,
)
from forest_description.hydraulics.compensator_parameters import Compensator
from forest_description.hydraulics.valve_characteristic import (
    CURVE_SIZE,
    LINEAR_AREA,
    POLYNOMIAL,
    TABLE,
    Curve,
    Direction,
    Knots,
    ValveLaw,
)
from forest_description.types import Floats

JET_ANGLE = math.radians(69.0)  # [rad] of the jet through a sharp edge to the spool's axis: von Mises


@dataclass(frozen=True)
class PolynomialCurve(ParameterSet):
    """C_R as a polynomial of the voltage, as the thesis fits it (section 4.3.2); only its shape counts."""

    kind: ClassVar[str] = "polynomial"

    coefficients: tuple[float, ...] = curve(
        "1", -1e30, 1e30, "of C_R over the voltage in volts, lowest power first, any scale"
    )

    def curve(self, deadband_voltage: float, rated_voltage: float) -> Curve:
        """Return the kernel's curve for a valve with this overlap [V] and rated voltage [V].

        Raises:
            MachineError: C_R is not positive, or grows, somewhere between the two voltages.
        """
        power = np.polynomial.Polynomial(self.coefficients)
        inner = np.polynomial.Polynomial([deadband_voltage, rated_voltage - deadband_voltage])
        in_stroke = power(inner)
        s = np.linspace(0.0, 1.0, 1001)
        if not (np.all(in_stroke(s) > 0.0) and np.all(np.diff(in_stroke(s)) <= 0.0)):
            raise MachineError(
                f"curve.coefficients: C_R must be positive and fall from {deadband_voltage:g} to "
                f"{rated_voltage:g} V"
            )
        values = (np.asarray(in_stroke.coef, np.float64) / float(in_stroke(1.0))).tolist()
        return Curve(POLYNOMIAL, LINEAR_AREA.knots, _filled("curve.coefficients", values, 0.0))


@dataclass(frozen=True)
class TableCurve(ParameterSet):
    """C_R as measured at some voltages; the opening is straight in between. Only its shape counts."""

    kind: ClassVar[str] = "table"

    voltages: tuple[float, ...] = curve(
        "V", 0.0, 50.0, "rising, from the edge of the overlap to the rated one"
    )
    resistances: tuple[float, ...] = curve(
        "Pa*s2/m6", 1e6, 1e30, "C_R there, falling; the overlap's is not given"
    )

    def curve(self, deadband_voltage: float, rated_voltage: float) -> Curve:
        """Return the kernel's curve; below the first voltage the opening falls to zero at the overlap's edge.

        Raises:
            MachineError: The rows do not fit each other or the valve's voltages, or C_R grows.
        """
        strokes = _strokes(self.voltages, "resistances", self.resistances, deadband_voltage, rated_voltage)
        c_r = np.array(self.resistances)
        if np.any(np.diff(c_r) > 0.0):
            raise MachineError("curve.resistances must fall with the voltage")
        return _table(strokes, "resistances", np.sqrt(c_r[-1] / c_r))


@dataclass(frozen=True)
class FlowCurve(ParameterSet):
    """Flow as data sheets print it: at some voltages, all at one pressure drop. Only its shape counts."""

    kind: ClassVar[str] = "flow"

    voltages: tuple[float, ...] = curve(
        "V", 0.0, 50.0, "rising, from the edge of the overlap to the rated one"
    )
    flows: tuple[float, ...] = curve(
        "m3/s", 1e-9, 1.0, "through an edge there, rising; the overlap's is not given"
    )

    def curve(self, deadband_voltage: float, rated_voltage: float) -> Curve:
        """Return the kernel's curve; at one pressure drop the opening is in proportion to the flow.

        Raises:
            MachineError: The rows do not fit each other or the valve's voltages, or the flow falls.
        """
        strokes = _strokes(self.voltages, "flows", self.flows, deadband_voltage, rated_voltage)
        flows = np.array(self.flows)
        if np.any(np.diff(flows) < 0.0):
            raise MachineError("curve.flows must rise with the voltage")
        return _table(strokes, "flows", flows / flows[-1])


def _strokes(
    voltages: tuple[float, ...], name: str, row: tuple[float, ...], deadband_voltage: float, rated: float
) -> Floats:
    """Return the strokes s of a curve's voltages [V] beside a row of its own; a ``MachineError`` if unfit."""
    volts = np.array(voltages)
    if len(volts) != len(row):
        raise MachineError(
            f"curve.voltages ({len(volts)}) and curve.{name} ({len(row)}) must be equally many"
        )
    s: Floats = (volts - deadband_voltage) / (rated - deadband_voltage)
    if np.any(np.diff(volts) <= 0.0) or s[0] <= 0.0 or not math.isclose(s[-1], 1.0):
        raise MachineError(
            f"curve.voltages must rise from above deadband_voltage ({deadband_voltage:g} V) to "
            f"rated_voltage ({rated:g} V)"
        )
    s[-1] = 1.0
    return s


def _table(strokes: Floats, name: str, openings: Floats) -> Curve:
    """Return a curve through openings at strokes, and through zero at the overlap's edge."""
    return Curve(
        TABLE,
        _filled("curve.voltages", [0.0, *strokes.tolist()], 1.0),
        _filled(f"curve.{name}", [0.0, *openings.tolist()], 1.0),
    )


def _filled(what: str, numbers: list[float], last: float) -> Knots:
    """Return numbers as a curve's row, filled up; a ``MachineError`` if they are too many."""
    if len(numbers) > CURVE_SIZE:
        more = len(numbers) - CURVE_SIZE
        raise MachineError(f"{what}: {more} too many; a curve has at most {CURVE_SIZE} places")
    row: Any = (*numbers, *[last] * (CURVE_SIZE - len(numbers)))
    return cast(Knots, row)


@dataclass(frozen=True)
class BackwardValve(ParameterSet):
    """The negative direction of a valve that is not the same both ways."""

    deadband_voltage: float = parameter("V", -5.0, 5.0, "overlap of the negative direction")
    minimum_resistance: float = parameter(
        "Pa*s2/m6", 1e9, 1e18, "C_R at the rated voltage, negative direction"
    )


@dataclass(frozen=True)
class Valve(ParameterSet):
    """Proportional spool valve; its law: `valve_characteristic`. Thesis section 2.3, 3.2.2, 4.3.2."""

    deadband_voltage: float = parameter(
        "V", -5.0, 5.0, "overlap: no flow up to it; 0 critical, negative underlap"
    )
    rated_voltage: float = parameter("V", 1.0, 50.0, "voltage of the fully open spool")
    minimum_resistance: float = parameter(
        "Pa*s2/m6", 1e9, 1e18, "orifice resistance C_R at the rated voltage, edges of port 1"
    )
    port_2_area: float = parameter("1", 0.05, 20.0, "area of port 2's edges over that of port 1's")
    leakage_conductance: float = parameter(
        "m3/(s*Pa)", 0.0, 1e-9, "laminar leakage past each of the four edges, spool centred"
    )
    load_check: str = choice(
        "none", "ideal", doc="check valve between supply and spool: a load does not go back to the manifold"
    )
    backward: BackwardValve | None = component()
    curve: PolynomialCurve | TableCurve | FlowCurve | None = component()
    spool_bandwidth: float | None = parameter(
        "Hz", 0.1, 500.0, "of the spool's lag; null: it follows at once"
    )
    spool_damping: float | None = parameter(
        "1", 0.1, 5.0, "damping ratio of a second-order spool; null: first order"
    )
    hysteresis: float | None = optional_parameter(
        "V", 0.0, 5.0, "width of the spool's play: up and down apart by it"
    )
    dead_time: float | None = optional_parameter(
        "s", 0.0005, 0.02, "of electronics and pilot stage; a voltage acts so much later"
    )
    spool_slew_limit: float | None = optional_parameter("V/s", 1.0, 1e5, "greatest rate of the spool")
    compensator: Compensator | None = None  # may be left out
    centring_force: float | None = optional_parameter(
        "N/V", 0.1, 1e5, "of the spring for each volt of stroke, against flow forces; left out: none act"
    )
    leakage_edge_ratio: float | None = optional_parameter(
        "1", 1.001, 1000.0, "leakage at the overlap's edge over that at the centre; left out: 1"
    )

    def __post_init__(self) -> None:
        """Check ranges, that the valve opens at all, the spool's lag, and the curve."""
        super().__post_init__()
        if self.spool_damping is not None and self.spool_bandwidth is None:
            raise MachineError(
                f"spool_damping ({self.spool_damping:g}) is of a lag that spool_bandwidth: null leaves out; "
                f"allowed: null, or a spool_bandwidth"
            )
        if self.centring_force is not None and self.spool_bandwidth is None:
            raise MachineError(
                "centring_force is of a spool that flow forces push; allowed: with a spool_bandwidth"
            )
        require_order("deadband_voltage", self.deadband_voltage, "rated_voltage", self.rated_voltage, "V")
        if self.backward is not None:
            edge = self.backward.deadband_voltage
            require_order("backward.deadband_voltage", edge, "rated_voltage", self.rated_voltage, "V")
        self._check_play()
        self._check_leakage()
        _ = self.law

    def _check_play(self) -> None:
        """Raise unless the rated voltage opens both directions against the play."""
        back = self.deadband_voltage if self.backward is None else self.backward.deadband_voltage
        most = 2.0 * (self.rated_voltage - max(self.deadband_voltage, back))
        if self.hysteresis is not None and self.hysteresis >= most:
            raise MachineError(
                f"hysteresis ({self.hysteresis:g} V) keeps the valve shut at rated_voltage "
                f"({self.rated_voltage:g} V); allowed: below {most:g} V"
            )

    def _check_leakage(self) -> None:
        """Raise unless leakage that follows the overlap has both of them."""
        if self.leakage_edge_ratio is None:
            return
        least = self.deadband_voltage
        if self.backward is not None:
            least = min(least, self.backward.deadband_voltage)
        if self.leakage_conductance == 0.0 or least <= 0.0:
            raise MachineError(
                "leakage_edge_ratio is of leakage through an overlap; allowed: a leakage_conductance and a "
                "deadband_voltage above 0 in both directions"
            )

    def jet_stiffness(self, drop: float, density: float) -> float:
        """Return the greatest flow force [N/V] over the stroke at a pressure drop [Pa] over an edge.

        The law is that of `forest_sim.hydraulics.flow_force`; the edge's area is taken to be linear.
        """
        law = self.law
        return max(
            drop
            * math.sqrt(2.0 * density / min(way.resistance_1, way.resistance_2))
            * math.cos(JET_ANGLE)
            / (way.rated_voltage - way.deadband_voltage)
            for way in (law.forward, law.backward)
        )

    @property
    def law(self) -> ValveLaw:
        """The constants of ``valve_characteristic.py``'s functions."""
        back = self.backward
        c_forward = self.minimum_resistance
        c_backward = back.minimum_resistance if back else c_forward
        d_backward = back.deadband_voltage if back else self.deadband_voltage
        unequal = self.port_2_area**-2.0
        shape = LINEAR_AREA
        if self.curve is not None:
            shape = self.curve.curve(self.deadband_voltage, self.rated_voltage)
        return ValveLaw(
            forward=Direction(self.deadband_voltage, self.rated_voltage, c_forward, c_forward * unequal),
            backward=Direction(d_backward, self.rated_voltage, c_backward, c_backward * unequal),
            curve=shape,
            leakage=self.leakage_conductance,
            load_check=int(self.load_check == "ideal"),
            edge_ratio=self.leakage_edge_ratio or 1.0,
        )


@dataclass(frozen=True)
class PortValves(ParameterSet):
    """Relief and anti-cavitation valves at every actuator port; not in the thesis."""

    relief_pressure: float = parameter("Pa", 1e5, 1e8, "port pressure above which oil leaves to the tank")
    relief_conductance: float = parameter("m3/(s*Pa)", 1e-13, 1e-5, "flow per pressure above it")
    anticavitation_pressure: float = parameter("Pa", -1e5, 1e6, "port pressure below which the tank refills")
    anticavitation_conductance: float = parameter("m3/(s*Pa)", 1e-13, 1e-5, "flow per pressure below it")

    def __post_init__(self) -> None:
        """Check ranges, and that no port is emptied and filled at once."""
        super().__post_init__()
        low, high = self.anticavitation_pressure, self.relief_pressure
        require_order("anticavitation_pressure", low, "relief_pressure", high, "Pa")
