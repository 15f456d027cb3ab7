"""The one table of topics: name, type, values with units, rate, publishers and subscribers.

Nodes, recorder, bag reader, plots and ``docs/reference/topics.md`` are made from this table; see `topic_qos`
and `topic_reference`. Names are relative where a crane owns the topic, so that a namespace moves the whole
graph; ``/clock``, ``/diagnostics`` and ``/rosout`` belong to the ROS graph and are absolute.

====================  ======================================================================================
symbol                meaning
====================  ======================================================================================
labels                names of the values, in the order in which our nodes publish them
units                 unit of each label; three, comma-separated, where a label has three values (JointState)
absent           a sensor without a sample has no label in the message; a message without any is not sent
port 1, port 2        the sides that move the axis in its positive and negative direction
valve, actuator       place of a pressure transducer: at the valve's port, at the actuator's chamber
====================  ======================================================================================

This module imports no ROS: ``message_class`` does so when it is called.
"""

from __future__ import annotations

import importlib
from typing import Any, NamedTuple

JOINTS = ("swing", "boom", "stick")
ACTUATORS = ("swing_motor", "boom_cylinder", "stick_cylinder")
JOY_AXES = ("left_x", "left_y", "right_x", "right_y", "left_trigger", "right_trigger")
JOY_BUTTONS = (
    *("a", "b", "x", "y", "back", "guide", "start", "left_stick", "right_stick"),
    *("left_shoulder", "right_shoulder", "dpad_up", "dpad_down", "dpad_left", "dpad_right"),
    *("misc", "paddle_1", "paddle_2", "paddle_3", "paddle_4", "touchpad"),
)

SENSOR_RATE_HZ = 200.0
JOY_RATE_HZ = 100.0

FLOAT_ARRAY = "std_msgs/msg/Float64MultiArray"
JOINT_STATE = "sensor_msgs/msg/JointState"
JOY_TYPE = "sensor_msgs/msg/Joy"
POSE = "geometry_msgs/msg/PoseStamped"
TWIST = "geometry_msgs/msg/TwistStamped"


class Topic(NamedTuple):
    """One row of the table; ``rate_hz`` 0 means once, or when there is something to say."""

    name: str
    type: str
    labels: tuple[str, ...]
    units: tuple[str, ...]
    rate_hz: float
    doc: str
    publishers: tuple[str, ...]
    subscribers: tuple[str, ...]
    transient_local: bool = False
    recorded: bool = True
    late: bool = False  # read by nodes for what it tells slowly; in lockstep `LATE` steps after it was said
    sensed: bool = False  # a stream that others publish, too; the next sample makes up for a lost one


_XYZ = ("x", "y", "z")
_POSE, _POSE_UNITS = (*_XYZ, "qx", "qy", "qz", "qw"), ("m",) * 3 + ("1",) * 4
_PRESSURE_LABELS = tuple(
    f"{axis}_{port}_{place}" for axis in JOINTS for port in (1, 2) for place in ("valve", "actuator")
)
_ESTIMATED = ("deadband_forward", "gain_forward", "deadband_backward", "gain_backward", "damping")
_ESTIMATES = tuple(f"{axis}_{part}{end}" for axis in JOINTS for part in _ESTIMATED for end in ("", "_spread"))
_ESTIMATE_UNITS = tuple(
    unit
    for damping in ("N·m·s/rad", "N·s/m", "N·s/m")
    for unit in (*("V", "V", "m³/(s·V·√Pa)", "m³/(s·V·√Pa)") * 2, damping, damping)
)
_SIMULATOR, _CONTROLLER, _DRIVER = "simulator", "controller", "valve_driver"
_JOYSTICK, _NOBODY = "joystick", ()
_RATE = SENSOR_RATE_HZ

# fmt: off
JOY = Topic(
    "joy", JOY_TYPE, JOY_AXES, ("1",) * 6, JOY_RATE_HZ,
    "Levers -1..1 and buttons in game_controller order; any joystick node, or a replay.",
    (_JOYSTICK,), (_CONTROLLER,), sensed=True,
)
JOINT_STATES = Topic(
    "joint_states", JOINT_STATE, JOINTS, ("rad, rad/s, N·m",) * 3, _RATE,
    "Joints as a machine can know them: sampled angle, causal speed estimate, torque from pressures.",
    (_SIMULATOR,), (_CONTROLLER,), sensed=True,
)
ACTUATOR_STATES = Topic(
    "actuator_states", JOINT_STATE, ACTUATORS, ("rad, rad/s, N·m", "m, m/s, N", "m, m/s, N"), _RATE,
    "Swing motor and cylinders as a machine can know them.",
    (_SIMULATOR,), (_CONTROLLER, _DRIVER), sensed=True,
)
PRESSURES = Topic(
    "hydraulics/pressures", FLOAT_ARRAY, _PRESSURE_LABELS, ("Pa",) * 12, _RATE,
    "Gauge pressure by axis, port and place: the twelve transducers of the thesis.",
    (_SIMULATOR,), (_DRIVER,), sensed=True,
)
FLOWS = Topic(
    "hydraulics/flows", FLOAT_ARRAY, ("swing_1", "stick_1"), ("m³/s",) * 2, _RATE,
    "Flow into port 1, where a meter is (Table 4.2).",
    (_SIMULATOR,), _NOBODY, sensed=True,
)
SUPPLY = Topic(
    "hydraulics/supply", FLOAT_ARRAY, ("pressure", "flow", "saturation"), ("Pa", "m³/s", "1"), _RATE,
    "Pump: pressure, flow, and the part of its flow limit in use (1 is saturated; the ideal pump: 0).",
    (_SIMULATOR,), (_DRIVER,), sensed=True,
)
AUXILIARY = Topic(
    "hydraulics/auxiliary", FLOAT_ARRAY,
    (
        *("swing_spool", "boom_spool", "stick_spool", "case_drain_flow"),
        *("tank_temperature", "pump_temperature", "motor_temperature"),
        *("engine_speed", "platform_pitch", "platform_roll", "relief_openings"),
        *("anticavitation_openings", "unconverged_stages", "missed_deadlines"),
    ),
    ("V", "V", "V", "m³/s", "K", "K", "K", "rad/s", "rad", "rad", "1", "1", "1", "1"), _RATE,
    "Spools as the voltage that holds them, case drain, oil temperatures, engine, tilt; counts since start.",
    (_SIMULATOR,), _NOBODY, sensed=True,
)
VALVE_COMMANDS = Topic(
    "valve_commands", FLOAT_ARRAY, JOINTS, ("V",) * 3, _RATE,
    "Voltage of an ideal valve (no lap, linear, nominal pressure drop): an actuator speed.",
    (_CONTROLLER,), (_DRIVER,),
)
VALVE_VOLTAGES = Topic(
    "valve_voltages", FLOAT_ARRAY, JOINTS, ("V",) * 3, _RATE,
    "Voltage at the valve amplifier, with the deadband divided out.",
    (_DRIVER,), (_SIMULATOR, _CONTROLLER),
)
VALVE_DRIVER_STATUS = Topic(
    "valve_driver/status", FLOAT_ARRAY,
    (
        *(f"{axis}_saturated" for axis in JOINTS),
        *(f"{axis}_{way}_{what}" for axis in JOINTS for way in ("forward", "backward")
          for what in ("deadband", "deadband_spread", "gain", "gain_spread")),
    ),
    ("1",) * 3 + ("V", "V", "1", "1") * 6, 10.0,
    "1 where a valve cannot open as commanded; deadband and gain (1: the file's) as known, with spread.",
    (_DRIVER,), (_CONTROLLER,), late=True,
)
TIP_POSE = Topic(
    "tip/pose", POSE, _POSE, _POSE_UNITS, _RATE,
    "Tip by the measured joints: the URDF's frame `tip`; z up from the boom pivot, turned as the stick is.",
    (_CONTROLLER,), _NOBODY,
)
TIP_TWIST = Topic(
    "tip/twist", TWIST, _XYZ, ("m/s",) * 3, _RATE,
    "Tip velocity from the measured joints.",
    (_CONTROLLER,), _NOBODY,
)
TIP_TWIST_COMMAND = Topic(
    "tip/twist_command", TWIST, _XYZ, ("m/s",) * 3, _RATE,
    "Commanded tip velocity, after every limit; absent in joint mode.",
    (_CONTROLLER,), _NOBODY,
)
CONTROLLER_STATUS = Topic(
    "controller/status", FLOAT_ARRAY,
    ("factor", "limit", "armed", "joystick", "emergency_stop"), ("1",) * 5, _RATE,
    "What limits the command: factor 0..1; codes of limit and joystick: explanation/safety.md; 0 or 1.",
    (_CONTROLLER,), _NOBODY,
)
EMERGENCY_STOP = Topic(
    "emergency_stop", "std_msgs/msg/Bool", (), (), 0.0,
    "True, from anybody, stops everything until it is reset on purpose; false asks for that.",
    (_CONTROLLER, _DRIVER), (_CONTROLLER, _DRIVER),
)
IDENTIFICATION = Topic(
    "identification/estimates", FLOAT_ARRAY, _ESTIMATES, _ESTIMATE_UNITS, 1.0,
    "What the on-line identification believes, each with its standard error.",
    ("online_identification",), _NOBODY,
)
EMERGENCY_STOPPED = Topic(
    "emergency_stopped", "std_msgs/msg/Bool", (), (), 0.0,
    "Whether a node stands still after an emergency stop, from its start on; true stops the others, too.",
    (_CONTROLLER, _DRIVER), (_CONTROLLER, _DRIVER), transient_local=True,
)
GROUND_TRUTH_JOINT_STATES = Topic(
    "ground_truth/joint_states", JOINT_STATE, JOINTS, ("rad, rad/s, N·m",) * 3, _RATE,
    "True joints of the simulator; for evaluation only.",
    (_SIMULATOR,), _NOBODY,
)
GROUND_TRUTH_TIP_POSE = Topic(
    "ground_truth/tip/pose", POSE, _POSE, _POSE_UNITS, _RATE,
    "True tip of the simulator, turned as the stick is; for evaluation only.",
    (_SIMULATOR,), _NOBODY,
)
GROUND_TRUTH_TIP_TWIST = Topic(
    "ground_truth/tip/twist", TWIST, _XYZ, ("m/s",) * 3, _RATE,
    "True tip velocity of the simulator; for evaluation only.",
    (_SIMULATOR,), _NOBODY,
)
ROBOT_DESCRIPTION = Topic(
    "robot_description", "std_msgs/msg/String", (), (), 0.0,
    "URDF made from the machine file.",
    (_SIMULATOR,), _NOBODY, transient_local=True,
)
EVENTS = Topic(
    "events", "std_msgs/msg/String", (), (), 0.0,
    "What the operator wants to be remembered; the recorder's service `mark` says it, anybody may.",
    ("recorder",), _NOBODY,
)
DIAGNOSTICS = Topic(
    "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray", (), (), 1.0,
    "Health of the nodes' inputs, of hardware and others where somebody tells it.",
    (_CONTROLLER, _DRIVER, _SIMULATOR), _NOBODY,
)
CLOCK = Topic(
    "/clock", "rosgraph_msgs/msg/Clock", ("time",), ("s",), _RATE,
    "Simulated time, in lockstep or where somebody publishes it. Live, our nodes run on the system's clock.",
    ("simulator in lockstep",), ("joystick in lockstep",),
)
ROSOUT = Topic(
    "/rosout", "rcl_interfaces/msg/Log", (), (), 0.0,
    "What the nodes log.",
    ("every node",), _NOBODY,
)
ANNOUNCEMENT = Topic(
    "lockstep/roll", "std_msgs/msg/String", (), (), 0.0,
    "In lockstep: a node's name and the topics on which it will speak in every step, line by line.",
    ("every node in lockstep",), ("recorder in lockstep",), transient_local=True, recorded=False,
)
NO_OUTPUT = Topic(
    "lockstep/silence", "std_msgs/msg/Header", (), (), _RATE,
    "In lockstep: topics on which a node said nothing in a step; 'end' when the step was the last.",
    ("every node in lockstep",), ("every node in lockstep",), recorded=False,
)
IDLE = Topic(
    "lockstep/quiet", "std_msgs/msg/Header", (), (), _RATE,
    "As lockstep/silence, of topics that no node reads.",
    ("every node in lockstep",), ("nodes in lockstep that read what comes late",), recorded=False,
)
STEP_BATCH = Topic(
    "lockstep/said", "std_msgs/msg/UInt8MultiArray", (), (), _RATE,
    "In lockstep: a node's messages of many steps, with their topics; see `forest_msgs_py.clock.step_batch`.",
    ("every node in lockstep",), ("recorder in lockstep",), recorded=False,
)
RECORDED = Topic(
    "lockstep/recorded", "rosgraph_msgs/msg/Clock", ("time",), ("s",), _RATE,
    "In lockstep: how far everything is in the bag; the machine stays near it.",
    ("recorder in lockstep",), ("simulator in lockstep",), recorded=False,
)
# fmt: on

TOPICS = tuple(row for row in list(globals().values()) if isinstance(row, Topic))
"""Every row above, in its order."""


def unlisted(name: str, type_name: str) -> Topic:
    """A row for a topic that is not in the table: somebody else's, or in a bag."""
    return Topic(name, type_name, (), (), 0.0, "", (), ())


def message_class(topic: Topic) -> Any:
    """The Python class of the topic's messages.

    Raises:
        ModuleNotFoundError: the message package is not installed.
    """
    package, _, name = topic.type.split("/")
    return getattr(importlib.import_module(f"{package}.msg"), name)


def find(name: str) -> Topic | None:
    """The row of a resolved topic name, whatever namespace the crane runs in (the longest match wins)."""
    matches = [row for row in TOPICS if f"/{name}".endswith("/" + row.name.lstrip("/"))]
    return max(matches, key=lambda row: len(row.name), default=None)
