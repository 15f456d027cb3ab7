"""The one table of topics: name, type, values with units, rate, publishers and subscribers.

Nodes, recorder, bag reader, plots and ``docs/reference/topics.md`` are made from this table; see
`topic_qos` and `topic_reference`. Names are relative where a crane owns the topic, so that a
namespace moves the whole graph; ``/clock``, ``/tf``, ``/diagnostics`` and the like belong to the ROS
graph and are absolute.

====================  ======================================================================================
symbol                meaning
====================  ======================================================================================
labels                names of the values, in the order in which our nodes publish them
units                 unit of each label; three, comma-separated, where a label has three values (JointState)
absent                a sensor without a sample has no label in the message; a message without any is not sent
port 1, port 2        the sides that move the axis in its positive and negative direction
valve, actuator       place of a pressure transducer: at the valve's port, at the actuator's chamber
====================  ======================================================================================

This module imports no ROS: ``message_class`` does so when it is called.
"""

import importlib
from typing import Any, NamedTuple

JOINTS = ("swing", "boom", "stick")
CYLINDER_JOINTS = ("boom_cylinder_pivot", "boom_cylinder_rod", "stick_cylinder_pivot", "stick_cylinder_rod")
HEAD_JOINTS = ("head_in_plane", "head_out_of_plane")
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
_JOYSTICK, _VIEWER, _NOBODY = "joystick", "viewer", ()
_LIVE_SIMULATOR = "simulator (live)"  # these are in no lockstep
_CYCLE, _TWIST, _PROGRAM = "cycle (live)", "twist (live)", "a program (live)"
_MONITOR = "monitor (live)"
_RATE = SENSOR_RATE_HZ

# fmt: off
JOY = Topic(
    name="joy", type=JOY_TYPE, labels=JOY_AXES, units=("1",) * 6, rate_hz=JOY_RATE_HZ,
    doc="Levers -1..1 and buttons in game_controller order; any joystick node, or a replay.",
    publishers=(_JOYSTICK,), subscribers=(_CONTROLLER, _CYCLE, _TWIST), sensed=True,
)
JOINT_STATES = Topic(
    name="joint_states", type=JOINT_STATE, labels=JOINTS, units=("rad, rad/s, N·m",) * 3, rate_hz=_RATE,
    doc="Joints as a machine can know them: sampled angle, causal speed estimate, torque from pressures.",
    publishers=(_SIMULATOR,), subscribers=(_CONTROLLER, _MONITOR), sensed=True,
)
ACTUATOR_STATES = Topic(
    name="actuator_states", type=JOINT_STATE, labels=ACTUATORS,
    units=("rad, rad/s, N·m", "m, m/s, N", "m, m/s, N"), rate_hz=_RATE,
    doc="Swing motor and cylinders as a machine can know them.",
    publishers=(_SIMULATOR,), subscribers=(_CONTROLLER, _DRIVER, _MONITOR), sensed=True,
)
PRESSURES = Topic(
    name="hydraulics/pressures", type=FLOAT_ARRAY, labels=_PRESSURE_LABELS, units=("Pa",) * 12, rate_hz=_RATE,
    doc="Gauge pressure by axis, port and place: the twelve transducers of the thesis.",
    publishers=(_SIMULATOR,), subscribers=(_CONTROLLER, _DRIVER, _MONITOR), sensed=True,
)
FLOWS = Topic(
    name="hydraulics/flows", type=FLOAT_ARRAY, labels=("swing_1", "stick_1"),
    units=("m³/s",) * 2, rate_hz=_RATE,
    doc="Flow into port 1, where a meter is (Table 4.2).",
    publishers=(_SIMULATOR,), subscribers=(_MONITOR,), sensed=True,
)
SUPPLY = Topic(
    name="hydraulics/supply", type=FLOAT_ARRAY, labels=("pressure", "flow", "saturation"),
    units=("Pa", "m³/s", "1"), rate_hz=_RATE,
    doc="Pump: pressure, flow, and the part of its flow limit in use (1 is saturated; the ideal pump: 0).",
    publishers=(_SIMULATOR,), subscribers=(_CONTROLLER, _DRIVER, _MONITOR), sensed=True,
)
AUXILIARY = Topic(
    name="hydraulics/auxiliary", type=FLOAT_ARRAY,
    labels=(
        *("swing_spool", "boom_spool", "stick_spool", "case_drain_flow"),
        *("tank_temperature", "pump_temperature", "motor_temperature"),
        *("engine_speed", "platform_pitch", "platform_roll", "relief_openings"),
        *("anticavitation_openings", "unconverged_stages", "missed_deadlines"),
    ),
    units=("V", "V", "V", "m³/s", "K", "K", "K", "rad/s", "rad", "rad", "1", "1", "1", "1"), rate_hz=_RATE,
    doc="Spools as the voltage that holds them, case drain, oil temperatures, engine, tilt; counts "
    "since start.",
    publishers=(_SIMULATOR,), subscribers=(_MONITOR,), sensed=True,
)
VALVE_COMMANDS = Topic(
    name="valve_commands", type=FLOAT_ARRAY, labels=JOINTS, units=("V",) * 3, rate_hz=_RATE,
    doc="Wanted actuator speeds, as voltages of ideal valves (no overlap, linear, nominal pressure drop).",
    publishers=(_CONTROLLER,), subscribers=(_DRIVER,),
)
VALVE_VOLTAGES = Topic(
    name="valve_voltages", type=FLOAT_ARRAY, labels=JOINTS, units=("V",) * 3, rate_hz=_RATE,
    doc="Voltage at the valve amplifier, with the deadband added.",
    publishers=(_DRIVER,), subscribers=(_SIMULATOR, _CONTROLLER, _MONITOR),
)
VALVE_DRIVER_STATUS = Topic(
    name="valve_driver/status", type=FLOAT_ARRAY,
    labels=(
        *(f"{axis}_saturated" for axis in JOINTS),
        *(f"{axis}_{way}_{what}" for axis in JOINTS for way in ("forward", "backward")
          for what in ("deadband", "deadband_spread", "gain", "gain_spread")),
    ),
    units=("1",) * 3 + ("V", "V", "1", "1") * 6, rate_hz=10.0,
    doc="1 where a valve cannot open as commanded; deadband and gain (1: the file's) as known, with spread.",
    publishers=(_DRIVER,), subscribers=(_CONTROLLER, _MONITOR), late=True,
)
TIP_POSE = Topic(
    name="tip/pose", type=POSE, labels=_POSE, units=_POSE_UNITS, rate_hz=_RATE,
    doc="Tip by the measured joints: the URDF's frame `tip`; z up from the boom pivot, turned as "
    "the stick is.",
    publishers=(_CONTROLLER,), subscribers=(_CYCLE, _TWIST),
)
TIP_TWIST = Topic(
    name="tip/twist", type=TWIST, labels=_XYZ, units=("m/s",) * 3, rate_hz=_RATE,
    doc="Tip velocity from the measured joints.",
    publishers=(_CONTROLLER,), subscribers=_NOBODY,
)
TIP_TWIST_COMMAND = Topic(
    name="tip/twist_command", type=TWIST, labels=_XYZ, units=("m/s",) * 3, rate_hz=_RATE,
    doc="Commanded tip velocity, after every limit; absent in joint mode.",
    publishers=(_CONTROLLER,), subscribers=_NOBODY,
)
CONTROLLER_STATUS = Topic(
    name="controller/status", type=FLOAT_ARRAY,
    labels=("factor", "limit", "armed", "joystick", "emergency_stop"), units=("1",) * 5, rate_hz=_RATE,
    doc="What limits the command: factor 0..1; codes of limit and joystick: reference/codes.md; 0 or 1.",
    publishers=(_CONTROLLER,), subscribers=(_CYCLE, _TWIST),
)
TIP_LOAD = Topic(
    name="tip/load", type=FLOAT_ARRAY, labels=("mass", "reach", "allowed", "share"),
    units=("kg", "m", "kg", "1"), rate_hz=_RATE,
    doc="Load under the tip, without the head, weighed by the boom's pressures; distance from the swing "
    "axis; what is allowed there, where the machine file tells a capacity; mass over that.",
    publishers=(_CONTROLLER,), subscribers=_NOBODY,
)
TAUGHT_COMMAND = Topic(
    name="tip/taught_command", type=FLOAT_ARRAY,
    labels=("run", *_XYZ, *(f"{part}_{i}" for part in ("tangent", "curvature") for i in _XYZ),
            "speed", "left"),
    units=("1", *("m",) * 3, *("1",) * 3, *("1/m",) * 3, "m/s", "m"), rate_hz=_RATE,
    doc="Taught work: a piece of the path near the tip, followed while the deadman is held and the "
    "levers are centred. A run's number rises; speed 0 ends it; left: to the path's next stop.",
    publishers=(_CYCLE, _TWIST), subscribers=(_CONTROLLER,),
)
CYCLE_STATUS = Topic(
    name="cycle/status", type=FLOAT_ARRAY,
    labels=("phase", "segment", "segments", "way", "length", "away"),
    units=("1", "1", "1", "m", "m", "m"), rate_hz=10.0,
    doc="Taught work: phase (reference/codes.md), segment from 1, way along its leg and its length, distance "
    "of the tip from the path.",
    publishers=(_CYCLE,), subscribers=_NOBODY,
)
JOINT_TRAJECTORY = Topic(
    name="joint_trajectory", type="trajectory_msgs/msg/JointTrajectory", labels=(), units=(), rate_hz=0.0,
    doc="Angles of swing, boom and stick at times, from a program: played as taught work is.",
    publishers=(_PROGRAM,), subscribers=(_CYCLE,),
)
TWIST_WISH = Topic(
    name="delta_twist_cmds", type=TWIST, labels=_XYZ, units=("m/s",) * 3, rate_hz=50.0,
    doc="Velocity that a program wishes the tip, in `base_link`; under MoveIt Servo's name.",
    publishers=(_PROGRAM,), subscribers=(_TWIST,), sensed=True,
)
EMERGENCY_STOP = Topic(
    name="emergency_stop", type="std_msgs/msg/Bool", labels=(), units=(), rate_hz=0.0,
    doc="True, from anybody, stops everything until it is reset on purpose; false asks for that.",
    publishers=(_CONTROLLER, _DRIVER, _LIVE_SIMULATOR), subscribers=(_CONTROLLER, _DRIVER, _LIVE_SIMULATOR),
)
IDENTIFICATION = Topic(
    name="identification/estimates", type=FLOAT_ARRAY, labels=_ESTIMATES, units=_ESTIMATE_UNITS, rate_hz=1.0,
    doc="What the on-line identification believes, each with its standard error.",
    publishers=("online_identification",), subscribers=_NOBODY,
)
EMERGENCY_STOPPED = Topic(
    name="emergency_stopped", type="std_msgs/msg/Bool", labels=(), units=(), rate_hz=0.0,
    doc="Whether a node stands still after an emergency stop, from its start on; true stops the others, too.",
    publishers=(_CONTROLLER, _DRIVER, _LIVE_SIMULATOR), subscribers=(_CONTROLLER, _DRIVER, _LIVE_SIMULATOR),
    transient_local=True,
)
GROUND_TRUTH_JOINT_STATES = Topic(
    name="ground_truth/joint_states", type=JOINT_STATE, labels=JOINTS,
    units=("rad, rad/s, N·m",) * 3, rate_hz=_RATE,
    doc="True joints of the simulator, links' bending included; for evaluation only.",
    publishers=(_SIMULATOR,), subscribers=_NOBODY,
)
GROUND_TRUTH_TIP_POSE = Topic(
    name="ground_truth/tip/pose", type=POSE, labels=_POSE, units=_POSE_UNITS, rate_hz=_RATE,
    doc="True tip of the simulator, turned as the stick is; for evaluation only.",
    publishers=(_SIMULATOR,), subscribers=_NOBODY,
)
GROUND_TRUTH_TIP_TWIST = Topic(
    name="ground_truth/tip/twist", type=TWIST, labels=_XYZ, units=("m/s",) * 3, rate_hz=_RATE,
    doc="True tip velocity of the simulator; for evaluation only.",
    publishers=(_SIMULATOR,), subscribers=_NOBODY,
)
GROUND_TRUTH_HEAD = Topic(
    name="ground_truth/head", type=JOINT_STATE, labels=HEAD_JOINTS,
    units=("rad, rad/s, N·m",) * 2, rate_hz=_RATE,
    doc="True joints of a hanging head: its sway; without effort, and only where the machine file has one.",
    publishers=("simulator with a hanging head",), subscribers=("viewer",),
)
GROUND_TRUTH_LOAD = Topic(
    name="ground_truth/load", type=FLOAT_ARRAY, labels=("mass", "length"), units=("kg", "m"), rate_hz=_RATE,
    doc="Log in the simulated head, 0 for none. In lockstep: with a schedule, or a log in the machine file.",
    publishers=(_SIMULATOR,), subscribers=_NOBODY,
)
GROUND_TRUTH_DEFLECTIONS = Topic(
    name="ground_truth/deflections", type=FLOAT_ARRAY, labels=JOINTS, units=("rad",) * 3, rate_hz=_RATE,
    doc="By how much simulated links are ahead of their joints; only where the machine file lets them bend.",
    publishers=("simulator with elastic links",), subscribers=("viewer",),
)
GROUND_TRUTH_PUMP = Topic(
    name="ground_truth/pump", type=FLOAT_ARRAY, labels=("displacement", "speed"), units=("1", "rad/s"),
    rate_hz=_RATE,
    doc="Simulated pump: displacement over its greatest, and the engine's speed; only where the machine "
    "file has a swash plate's times or an engine.",
    publishers=("simulator with a driven pump",), subscribers=_NOBODY,
)
GROUND_TRUTH_TANK_LINE = Topic(
    name="ground_truth/tank_line", type=FLOAT_ARRAY, labels=("pressure",), units=("Pa",), rate_hz=_RATE,
    doc="Simulated pressure behind the valves, before the tank's filter; only where the machine file has "
    "a tank line.",
    publishers=("simulator with a tank line",), subscribers=_NOBODY,
)
GROUND_TRUTH_COMPENSATORS = Topic(
    name="ground_truth/compensators", type=FLOAT_ARRAY, labels=JOINTS, units=("1",) * 3, rate_hz=_RATE,
    doc="Openings of simulated pressure compensators, 0 shut; NaN for a valve without one; only where the "
    "machine file has any.",
    publishers=("simulator with compensated valves",), subscribers=_NOBODY,
)
GROUND_TRUTH_TIP_OVER = Topic(
    name="ground_truth/tip_over", type=FLOAT_ARRAY, labels=("ahead", "left", "behind", "right"),
    units=("1",) * 4, rate_hz=_RATE,
    doc="Margins against tipping over the lines of wheels or legs, 0 where the others lift, by the weights "
    "alone; only where the machine file has a chassis.",
    publishers=("simulator with a chassis",), subscribers=_NOBODY,
)
VIEWER_JOINT_STATES = Topic(
    name="viewer/joint_states", type=JOINT_STATE, labels=(*JOINTS, *CYLINDER_JOINTS, *HEAD_JOINTS),
    units=(*("rad, rad/s, N·m",) * 4, "m, m/s, N", "rad, rad/s, N·m", "m, m/s, N", *("rad, rad/s, N·m",) * 2),
    rate_hz=50.0,
    doc="Position of every joint of the URDF: joint_states, with the bending of simulated links; cylinders "
    "and head computed from them.",
    publishers=(_VIEWER,), subscribers=("foxglove",),
)
VIEWER_MARKERS = Topic(
    name="viewer/markers", type="visualization_msgs/msg/MarkerArray", labels=(), units=(), rate_hz=10.0,
    doc="Trails of tip and command, work area, walls; each in a namespace of its own.",
    publishers=(_VIEWER,), subscribers=_NOBODY,
)
TF = Topic(
    name="/tf", type="tf2_msgs/msg/TFMessage", labels=(), units=(), rate_hz=50.0,
    doc="Frames of the moving links, from `viewer/joint_states`; where tf2_msgs is installed.",
    publishers=(_VIEWER,), subscribers=_NOBODY,
)
TF_STATIC = Topic(
    name="/tf_static", type="tf2_msgs/msg/TFMessage", labels=(), units=(), rate_hz=0.0,
    doc="Frames of the fixed links; where tf2_msgs is installed.",
    publishers=(_VIEWER,), subscribers=_NOBODY, transient_local=True,
)
ROBOT_DESCRIPTION = Topic(
    name="robot_description", type="std_msgs/msg/String", labels=(), units=(), rate_hz=0.0,
    doc="URDF made from the machine file.",
    publishers=(_SIMULATOR,), subscribers=_NOBODY, transient_local=True,
)
EVENTS = Topic(
    name="events", type="std_msgs/msg/String", labels=(), units=(), rate_hz=0.0,
    doc="What the operator wants to be remembered; the recorder's service `mark` says it, anybody may.",
    publishers=("recorder", _CYCLE), subscribers=_NOBODY,
)
DIAGNOSTICS = Topic(
    name="/diagnostics", type="diagnostic_msgs/msg/DiagnosticArray", labels=(), units=(), rate_hz=1.0,
    doc="Health of the nodes' inputs, of hardware and others where somebody tells it.",
    publishers=(_CONTROLLER, _DRIVER, _SIMULATOR, _CYCLE, _MONITOR), subscribers=_NOBODY,
)
CLOCK = Topic(
    name="/clock", type="rosgraph_msgs/msg/Clock", labels=("time",), units=("s",), rate_hz=_RATE,
    doc="Simulated time, in lockstep or where somebody publishes it. Live, our nodes run on the "
    "system's clock.",
    publishers=("simulator in lockstep",), subscribers=("joystick in lockstep",),
)
ROSOUT = Topic(
    name="/rosout", type="rcl_interfaces/msg/Log", labels=(), units=(), rate_hz=0.0,
    doc="What the nodes log.",
    publishers=("every node",), subscribers=_NOBODY,
)
ANNOUNCEMENT = Topic(
    name="lockstep/roll", type="std_msgs/msg/String", labels=(), units=(), rate_hz=0.0,
    doc="In lockstep: a node's name and the topics on which it will speak in every step, line by line.",
    publishers=("every node in lockstep",), subscribers=("recorder in lockstep",),
    transient_local=True, recorded=False,
)
NO_OUTPUT = Topic(
    name="lockstep/silence", type="std_msgs/msg/Header", labels=(), units=(), rate_hz=_RATE,
    doc="In lockstep: topics on which a node said nothing in a step; 'end' when the step was the last.",
    publishers=("every node in lockstep",), subscribers=("every node in lockstep",), recorded=False,
)
IDLE = Topic(
    name="lockstep/quiet", type="std_msgs/msg/Header", labels=(), units=(), rate_hz=_RATE,
    doc="As lockstep/silence, of topics that no node reads.",
    publishers=("every node in lockstep",), subscribers=("nodes in lockstep that read what comes late",),
    recorded=False,
)
STEP_BATCH = Topic(
    name="lockstep/said", type="std_msgs/msg/UInt8MultiArray", labels=(), units=(), rate_hz=_RATE,
    doc="In lockstep: a node's messages of many steps, with their topics; see "
    "`forest_msgs_py.clock.step_batch`.",
    publishers=("every node in lockstep",), subscribers=("recorder in lockstep",), recorded=False,
)
RECORDED = Topic(
    name="lockstep/recorded", type="rosgraph_msgs/msg/Clock", labels=("time",), units=("s",), rate_hz=_RATE,
    doc="In lockstep: how far everything is in the bag; the machine stays near it.",
    publishers=("recorder in lockstep",), subscribers=("simulator in lockstep",), recorded=False,
)
# fmt: on

TOPICS = tuple(row for row in list(globals().values()) if isinstance(row, Topic))
"""Every row above, in its order."""


def unlisted(name: str, type_name: str) -> Topic:
    """A row for a topic that is not in the table: somebody else's, or in a bag."""
    return Topic(
        name=name, type=type_name, labels=(), units=(), rate_hz=0.0, doc="", publishers=(), subscribers=()
    )


def columns(topic: Topic) -> tuple[str, ...]:
    """The numbers of one message, in the order in which values are packed into it.

    Raises:
        ValueError: the topic's messages are not made of a stamp and numbers.
    """
    if topic.type == JOINT_STATE:
        return tuple(f"{name}.{part}" for part in ("position", "velocity", "effort") for name in topic.labels)
    if topic.type in (FLOAT_ARRAY, POSE, TWIST):
        return topic.labels
    raise ValueError(f"{topic.name}: {topic.type} is not a stamp and numbers")


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
