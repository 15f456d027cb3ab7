"""The machine as a co-simulation unit: voltages and forces in, what sensors report and what is true out.

The importing tool's Python runs it. Outputs carry the names of the graph's topics:
`/hydraulics/pressures`, `boom_1_valve` is `hydraulics.pressures.boom_1_valve`.
"""

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element

from pythonfmu import Boolean, Fmi2Causality, Fmi2Slave, Fmi2Variability, Integer, Real

from forest_compile.kernel_cache import can_compile
from forest_description.derived.limits import start_tip
from forest_description.derived.temperature import at_temperature
from forest_description.geometry.kinematics import inverse_kinematics
from forest_description.machine import load_machine
from forest_description.types import AXES, Vec3
from forest_msgs_py.interfaces.topics import JOINT_STATE, Topic, columns
from forest_sim.sensors.sensor_run import KERNEL as SENSORS
from forest_sim.sensors.sensor_suite import sensor_suite
from forest_sim.simulation.disturbance import parse_disturbance
from forest_sim.simulation.load_schedule import checked_load, own_load
from forest_sim.simulation.open_loop import RunError, require_within_limits
from forest_sim.simulation.sensor_log import SIMULATED_TOPICS, further_topics, topic_values
from forest_sim.simulation.simulated_machine import STEP, SimulatedMachine
from forest_sim.simulation.voltage_profiles import GREATEST
from forest_sim.solver.plant_kernel import KERNEL as PLANT

MACHINE_FILE = "machine.yaml"
"""Beside the unit: the machine that it is."""
NAMESPACES: list[dict[str, Any]] = []
"""Of the scripts that made units in this process."""
STEP_TOLERANCE = 1e-9  # [s]
NO_OPTIONS: Mapping[str, str] = {}
COUNTED = ("missed_deadlines",)  # of a node, which a unit is not


class CraneUnit(Fmi2Slave):
    """A machine that starts at rest.

    Args:
        arguments: `instance_name` and `resources`, the folder of `MACHINE_FILE`; from pythonfmu.

    Raises:
        MachineError: the machine file is wrong.
    """

    author, license = "forest-crane", "Apache-2.0"

    def __init__(self, **arguments: Any) -> None:
        super().__init__(**arguments)
        self._crane = load_machine(str(Path(self.resources) / MACHINE_FILE))
        self.modelName = re.sub(r"\W", "_", self._crane.name)
        self.description = self._crane.description
        links = self._crane.manipulator.links
        self._values: dict[str, Any] = dict(
            zip(_of_axes("start"), inverse_kinematics(start_tip(self._crane), links), strict=True)
        )
        self._values |= {"sensor_noise": False, "seed": 0} | dict.fromkeys((*VOLTAGES, *FORCES), 0.0)
        self._values |= zip(LOAD, own_load(self._crane.manipulator), strict=True)
        for name in _of_axes("start"):
            self._add(Real, name, "angle of the joint at the start [rad]", Fmi2Causality.parameter)
        if self._crane.oil is not None:
            self._values["oil_temperature"] = self._crane.oil.reference_temperature
            self._add(Real, "oil_temperature", "at the start [K]", Fmi2Causality.parameter)
        self._add(Boolean, "sensor_noise", "sensors as the machine file says", Fmi2Causality.parameter)
        self._add(Integer, "seed", "of the sensors' errors and noise", Fmi2Causality.parameter)
        for name in VOLTAGES:
            self._add(Real, name, "of the valve [V]", Fmi2Causality.input)
        for name in FORCES:
            self._add(Real, name, "on the tip, in the base frame [N]", Fmi2Causality.input)
        for name, unit in zip(LOAD, ("kg", "m"), strict=True):
            self._add(Real, name, f"of the log that the head holds [{unit}]", Fmi2Causality.input)
        self._machine, self._further = self._at_rest(), further_topics(self._crane, has_loads=True)
        self._tell_start()
        for topic in (*SIMULATED_TOPICS, *self._further):
            for name, unit in _outputs(topic):
                if not math.isnan(self._values[name]):  # a sensor that this machine does not have
                    self._add(Real, name, f"/{topic.name} [{unit}]", Fmi2Causality.output)

    def to_xml(self, model_options: Mapping[str, str] = NO_OPTIONS) -> Element:
        """Return the unit's description; FMI 2.0 wants outputs among the initial unknowns, too.

        Args:
            model_options: of pythonfmu.
        """
        root: Element = super().to_xml(dict(model_options))
        (structure,) = root.iter("ModelStructure")
        structure.append(Element("InitialUnknowns"))
        structure[-1].extend(structure[0])
        return root

    def exit_initialization_mode(self) -> None:
        """Put the machine to rest at the joint angles that the tool has set.

        Raises:
            RunError: an angle is not within its joint's limits.
        """
        self._machine = self._at_rest()
        self._tell_start()

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Move on under held inputs; an error ends the unit, and the tool's log tells why.

        Args:
            current_time: [s].
            step_size: a whole number of the integrator's steps [s].

        Raises:
            RunError: another step.
            ValueError: an input is out of its range.
        """
        count = round(step_size / STEP)
        if count < 1 or abs(count * STEP - step_size) > STEP_TOLERANCE:
            raise RunError(f"a step of {step_size:g} s; allowed: multiples of {STEP:g} s")
        voltages, force = self._three(VOLTAGES), self._three(FORCES)
        if not all(abs(volt) <= GREATEST for volt in voltages):  # false for NaN as well
            raise ValueError(f"voltages {voltages} V at {current_time:g} s; allowed: +-{GREATEST:g} V")
        self._machine.disturb(parse_disturbance("", force))
        load = checked_load(*(self._values[name] for name in LOAD))
        if load != self._machine.load:
            self._machine.hold(load)
        for _ in range(count):
            report = self._machine.step(voltages)
        self._tell(topic_values(report, self._machine.events))
        return True

    def _at_rest(self) -> SimulatedMachine:
        crane = self._crane
        if crane.oil is not None:
            crane = at_temperature(crane, self._values["oil_temperature"])
        angles = require_within_limits(crane, self._three(_of_axes("start")))
        if can_compile():
            for kernel in (PLANT, SENSORS):
                kernel.kernel()
        suite = sensor_suite(crane, self._values["sensor_noise"], self._values["seed"])
        return SimulatedMachine(crane, angles, suite, STEP)

    def _tell_start(self) -> None:
        self._tell(topic_values(self._machine.at_rest, self._machine.events))

    def _tell(self, values: dict[Topic, tuple[float, ...]]) -> None:
        values |= {topic: told(self._machine) for topic, told in self._further.items()}
        for topic, numbers in values.items():
            names = (f"{_dotted(topic)}.{column}" for column in columns(topic))
            self._values.update(zip(names, numbers, strict=True))

    def _three(self, names: tuple[str, ...]) -> Vec3:
        one, two, three = (self._values[name] for name in names)
        return one, two, three

    def _add(self, kind: Any, name: str, text: str, causality: Fmi2Causality) -> None:
        """Make a value a variable of the unit."""

        def assign(value: Any) -> None:
            self._values[name] = value

        fixed = causality == Fmi2Causality.parameter
        changes = Fmi2Variability.fixed if fixed else Fmi2Variability.continuous
        variable = kind(
            name,
            causality=causality,
            description=text,
            variability=changes,
            getter=lambda: self._values[name],
            setter=assign,
        )
        self.register_variable(variable, nested=False)


def _of_axes(word: str) -> tuple[str, ...]:
    return tuple(f"{word}.{axis}" for axis in AXES)


def _dotted(topic: Topic) -> str:
    return topic.name.replace("/", ".")


def _outputs(topic: Topic) -> Iterator[tuple[str, str]]:
    """Give the variables of a topic, each with its unit."""
    units = topic.units
    if topic.type == JOINT_STATE:
        units = tuple(of_label.split(", ")[part] for part in range(3) for of_label in topic.units)
    for column, unit in zip(columns(topic), units, strict=True):
        if column not in COUNTED:
            yield f"{_dotted(topic)}.{column}", unit


VOLTAGES = _of_axes("voltage")
LOAD = ("load.mass", "load.length")
FORCES = tuple(f"tip_force.{axis}" for axis in "xyz")
