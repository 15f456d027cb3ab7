"""What reads files and messages of others: whatever comes, it returns, or refuses in a sentence."""

from __future__ import annotations

import argparse
import contextlib
import functools
import math
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from forest_bag.read.bag_reader import BagReader
from forest_bag.read.timeseries import read_bag
from forest_bag.recovery.bag_recovery import recover
from forest_bag.storage.bag_files import BagError
from forest_bag.write.bag_split import Layout
from forest_bag.write.bag_writer import BagWriter
from forest_control.config.joystick_file import load_devices
from forest_control.config.profile_file import load_profile
from forest_control.config.setting_file import SettingFileError
from forest_control.config.workspace_file import load_workspace
from forest_control.operator.joystick_fault_injection import parse_joystick_faults
from forest_control.operator.joystick_sources import LeverError, read_levers
from forest_control.taught.cycle_file import load_cycle
from forest_description.config.parameter import MachineError
from forest_description.machine import load_machine
from forest_ident.measurements import session_bag
from forest_ident.measurements.session import SessionError
from forest_msgs_py.interfaces import messages, topics
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.runtime.command_line import number, whole
from forest_msgs_py.serialization.cdr import CdrError, cdr_type, to_cdr
from forest_msgs_py.serialization.packing import pack_joy
from forest_msgs_py.serialization.unpacking import ArrayReader, JointReader, read_joy_data
from forest_sim.sensors.sensor_faults import parse_faults
from forest_sim.simulation.disturbance import parse_stuck_spools
from forest_sim.simulation.load_schedule import parse_loads
from forest_sim.simulation.voltage_profiles import InputError, read_voltages
from forest_station.operator.hands_message import Hands, HandsError, decode_hands, encode_hands
from forest_station.server.requests import read_request
from forest_study.results import StudyError
from forest_study.sweep.study import read_study

LONGEST = 1.0  # [s] of processor for an input
ROOT = Path(__file__).resolve().parents[2]
SRC, CORPUS = ROOT / "src", ROOT / "test" / "fuzz" / "corpus"


class Target(NamedTuple):
    """A reader, the errors that it may raise, and bytes that it reads well."""

    read: Callable[[bytes], Any]
    refuses: tuple[type[Exception], ...]
    seeds: Callable[[], list[bytes]]


def as_file(name: str, read: Callable[[Path], Any], data: bytes) -> None:
    """Have a reader of files read bytes."""
    with tempfile.TemporaryDirectory(prefix="forest-fuzz-") as folder:
        path = Path(folder) / name
        path.write_bytes(data)
        read(path)


def shipped(package: str, folder: str) -> list[bytes]:
    """Return what a package ships as files of a kind."""
    return [path.read_bytes() for path in (SRC / package / package / folder).glob("*.yaml")]


@functools.cache
def small_bag(storage: str = "mcap") -> dict[str, bytes]:
    """Return the files of a bag of a few messages."""
    with tempfile.TemporaryDirectory() as folder:
        topic, layout = topics.VALVE_COMMANDS, Layout("none", chunk_bytes=200, storage=storage)
        with contextlib.closing(BagWriter(Path(folder) / "bag", layout)) as writer:
            writer.add_topic("/valve_commands", topic.type, [offered_qos(topic)], "")
            for k in range(3):
                data = to_cdr(messages.float_array(topic, k, (1.0, 2.0, 3.0)))
                writer.write("/valve_commands", data, k, k, k)
        return {path.suffix: path.read_bytes() for path in writer.directory.iterdir()}


def read_metadata(data: bytes) -> None:
    """Open a bag whose metadata are these bytes."""
    with tempfile.TemporaryDirectory(prefix="forest-fuzz-") as folder:
        (Path(folder) / "metadata.yaml").write_bytes(data)
        (Path(folder) / "bag_0.mcap").write_bytes(small_bag()[".mcap"])
        BagReader(folder).close()


def recovered(path: Path) -> None:
    """Recover a file into a bag beside it."""
    recover([path], path.with_name("out"))


def levers_and_joints(data: bytes) -> None:
    """Read a message as each of the nodes' readers does: finite numbers or a problem, never both."""
    for reading in (
        ArrayReader(topics.VALVE_COMMANDS).read(data, 0),
        JointReader(topics.JOINTS).read(data),
        read_joy_data(data, 6, 21)[0],
    ):
        if reading.problem:
            assert "; allowed: " in reading.problem
        else:
            numbers = [x for part in reading.values for x in (part if isinstance(part, tuple) else (part,))]
            assert all(map(math.isfinite, numbers))


def any_message(data: bytes) -> None:
    """Decode bytes as the types of the table."""
    for kind in (topics.FLOAT_ARRAY, topics.JOINT_STATE, "diagnostic_msgs/msg/DiagnosticArray"):
        with contextlib.suppress(CdrError):
            cdr_type(kind).decode(data)


def command_words(data: bytes) -> None:
    """Read a text as what people type at commands: each parser returns, or says what is allowed."""
    text = data.decode("utf-8", "replace")
    for parse in WORDS:
        refusal = refused(parse, text)
        assert refusal is None or "allowed: " in refusal or "there are " in refusal, refusal


def refused(parse: Callable[[str], Any], text: str) -> str | None:
    """Return what is wrong with a text, or None."""
    try:
        parse(text)
    except (ValueError, argparse.ArgumentTypeError) as error:
        return str(error)
    return None


def said() -> list[bytes]:
    """Return a message of each kind that nodes read."""
    joint = messages.joint_state(topics.JOINTS, 5, (0.1, 0.2, 0.3), (0.0, 0.1, 0.2), (1.0, 2.0, 3.0))
    levers = messages.JoyValues((0.0,) * 6, (0,) * 21)
    return [
        to_cdr(messages.float_array(topics.VALVE_COMMANDS, 5, (1.0, 2.0, 3.0))),
        to_cdr(joint),
        pack_joy(5, "heartbeat:1", levers),
    ]


def texts(*lines: str) -> Callable[[], list[bytes]]:
    """Return what gives some texts as seeds."""
    return lambda: [line.encode() for line in lines]


WORDS: tuple[Callable[[str], Any], ...] = (
    *(parse_loads, parse_faults, parse_joystick_faults, parse_stuck_spools),
    *(whole(1, 9), number(0.0, 9.0, "s")),
)
STUDY = """kind: track
with: {machine: c180_hoses, noise: false}
vary:
  path: [sweep, radial]
  plant.manipulator.platform_tilt: {low: -5, high: 5, unit: deg}
  control.feedback_gain.boom: {low: 1, high: 4}
design: sobol
points: 8
seeds: 3
"""
MAPPING = """devices:
  left:
    name: "Maker's*"
    axes: {left_x: -ABS_X, left_y: ABS_Y, right_y: ABS_RY}
    buttons: {left_shoulder: BTN_TL, dpad_up: [-ABS_HAT0Y, BTN_DPAD_UP]}
    range: {ABS_X: [60, 512, 960]}
"""
CYCLE = """description: two
segments:
  - {name: go, pose: [5, 0, 1], speed: 0.3}
  - {path: [[5, 0, 1], [6, 0, 1]]}
  - {grapple: open, wait: 1}
"""
FACTS = "experiment: gravity\nfacts: {hose_length: {value: 3.0, unit: m}, laminar: {value: 1, unit: '1'}}\n"
LEVERS = "time_s,swing,boom,stick\n0,0,0,0\n1,0.5,-1,1\n"
VOLTS = "time,swing,boom,stick\n0,-4,4,4\n60,0,0,0\n"
HANDS = Hands(True, 1, 0.1, (0.0,) * 6, 1, 1)
OF_SETTINGS = SettingFileError, OSError
TARGETS = {
    "messages": Target(levers_and_joints, (), said),
    "cdr": Target(any_message, (), said),
    "mcap": Target(
        partial(as_file, "x_0.mcap", BagReader), (BagError, OSError), lambda: [small_bag()[".mcap"]]
    ),
    "series": Target(
        partial(as_file, "x_0.mcap", read_bag), (BagError, OSError), lambda: [small_bag()[".mcap"]]
    ),
    "recovery": Target(
        partial(as_file, "x_0.mcap", recovered), (BagError, OSError), lambda: [small_bag()[".mcap"]]
    ),
    "sqlite": Target(
        partial(as_file, "x_0.db3", read_bag), (BagError, OSError), lambda: [small_bag("sqlite3")[".db3"]]
    ),
    "metadata": Target(read_metadata, (BagError, OSError), lambda: [small_bag()[".yaml"]]),
    "machine": Target(
        partial(as_file, "m.yaml", load_machine),
        (MachineError,),
        texts("based_on: c180\nboom_mass: 700\n", "based_on: c180_hoses\n"),
    ),
    "profile": Target(
        partial(as_file, "p.yaml", lambda path: load_profile(str(path))),
        OF_SETTINGS,
        lambda: [*shipped("forest_control", "profiles"), b"mode: rate\nexpo: 0.4\ndeadzone: [0, 0.1, 0.2]\n"],
    ),
    "workspace": Target(
        partial(as_file, "w.yaml", lambda path: load_workspace(str(path))),
        OF_SETTINGS,
        lambda: shipped("forest_control", "workspaces"),
    ),
    "joysticks": Target(
        partial(as_file, "j.yaml", lambda path: load_devices(str(path), 9)),
        OF_SETTINGS,
        lambda: [*shipped("forest_control", "joysticks"), MAPPING.encode()],
    ),
    "cycle": Target(
        partial(as_file, "c.yaml", lambda path: load_cycle("c", path.parent)),
        OF_SETTINGS,
        lambda: [*shipped("forest_control", "cycles"), CYCLE.encode()],
    ),
    "study": Target(partial(as_file, "s.yaml", read_study), (StudyError,), texts(STUDY)),
    "experiment": Target(
        partial(as_file, session_bag.FILE, lambda path: session_bag._experiment(path.parent)),
        (SessionError,),
        texts(FACTS),
    ),
    "words": Target(
        command_words,
        (),
        texts(
            "500 kg from 1 s; 0 kg from 2e1 s", "boom_resolver: bias 2 deg from 1 s", "release", "boom", "7"
        ),
    ),
    "levers": Target(partial(as_file, "l.csv", read_levers), (LeverError,), texts(LEVERS)),
    "voltages": Target(partial(as_file, "v.csv", read_voltages), (InputError,), texts(VOLTS)),
    "hands": Target(decode_hands, (HandsError,), lambda: [encode_hands(HANDS)]),
    "requests": Target(
        lambda data: read_request(data.decode("utf-8", "replace")), (), texts('{"do": "seat", "number": 1}')
    ),
}


def run(name: str, data: bytes) -> None:
    """Read bytes; what a reader refuses in its own way is well, anything else raises."""
    target, begun = TARGETS[name], time.process_time()
    refusal: Exception | None = None
    try:
        target.read(data)
    except target.refuses as error:
        refusal = error
    assert refusal is None or str(refusal).strip(), "it is refused without a word"
    assert time.process_time() - begun < LONGEST, "it takes too long"


def corpus(name: str) -> list[bytes]:
    """Return what fuzzing has found so far that runs lines of its own."""
    return [path.read_bytes() for path in sorted((CORPUS / name).glob("*"))]


def warm(name: str) -> None:
    """Read the seeds: what is imported or compiled then takes its time once."""
    for seed in TARGETS[name].seeds():
        with contextlib.suppress(*TARGETS[name].refuses):
            TARGETS[name].read(seed)
