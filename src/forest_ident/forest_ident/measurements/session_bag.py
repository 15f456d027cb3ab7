"""Sessions on disk: a bag of the graph's topics, and an `experiment.yaml` beside it.

The bag is the recorder's: sensors, commands and voltages. A simulator's ground truth is not read.
`experiment.yaml` in its directory names the experiment and the facts that no sensor measures, with units; a
person who runs the experiment otherwise writes it by hand.
Without that file a bag is a "motion".
"""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from forest_bag.read.timeseries import Bag, NotInBag, read_bag
from forest_bag.write.bag_split import Layout
from forest_bag.write.bag_writer import BagWriter
from forest_description.types import AXES, Floats
from forest_ident.experiments.experiment_metadata import FACTS, value
from forest_ident.measurements.readings import speeds
from forest_ident.measurements.session import Session, SessionError
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import (
    ACTUATOR_STATES,
    AUXILIARY,
    FLOWS,
    JOINT_STATES,
    PRESSURES,
    SUPPLY,
    VALVE_COMMANDS,
    VALVE_VOLTAGES,
    Topic,
)
from forest_msgs_py.interfaces.yaml_text import read_yaml
from forest_msgs_py.serialization.batch_encoder import Encoder

FILE = "experiment.yaml"
SAME_CLOCK = 1_000_000_000  # [ns] by which a message may be sent later than it is stamped
HOLE = 0.5  # [s] without samples: what moved meanwhile, nobody knows
SLOW = 3.0  # times the usual distance of a sensor's samples, the same where that is long
TICK = 1000  # [ns]
CHUNK_BYTES = 1024 * 1024
POSITION = ".position"  # ends a label of topics with positions and speeds
# Channel of the sensors to (topic, label), for what is written and read alike.
PLACES: dict[str, tuple[Topic, str]] = {
    **{f"{axis}_resolver": (JOINT_STATES, f"{axis}{POSITION}") for axis in AXES},
    **{f"{axis}_transducer": (ACTUATOR_STATES, f"{axis}_cylinder{POSITION}") for axis in AXES[1:]},
    **{
        f"{axis}_pressure_{port}_{place}": (PRESSURES, f"{axis}_{port}_{place}")
        for axis in AXES
        for port in (1, 2)
        for place in ("valve", "actuator")
    },
    "swing_flow": (FLOWS, "swing_1"),
    "stick_flow": (FLOWS, "stick_1"),
    "supply_pressure": (SUPPLY, "pressure"),
    **{f"{axis}_spool": (AUXILIARY, f"{axis}_spool") for axis in AXES},
    "case_drain": (AUXILIARY, "case_drain_flow"),
    **{
        name: (AUXILIARY, name)
        for name in (
            *("tank_temperature", "pump_temperature", "motor_temperature"),
            *("engine_speed", "platform_pitch", "platform_roll"),
        )
    },
}


def write(session: Session, directory: Path) -> None:
    """Write a session as a bag with its `experiment.yaml`.

    Raises:
        FileExistsError: the directory exists.
        OSError: it cannot be written.
    """
    writer = BagWriter(directory, Layout(chunk_bytes=CHUNK_BYTES))
    stamps = np.round(session.time * 1e9).astype(np.int64)
    encoded = []
    for topic, labels, values in _tables(session):
        reduced = topic._replace(labels=labels, units=tuple("" for _ in labels))
        writer.add_topic(f"/{topic.name}", topic.type, [offered_qos(topic)], "")
        encoded.append((f"/{topic.name}", Encoder(reduced).encode(stamps, values)))
    try:
        for row, stamp in enumerate(stamps.tolist()):
            for name, messages in encoded:
                data = messages[row]
                if data is not None:
                    writer.write(name, data, stamp, stamp, row + 1)
    finally:
        writer.close()
    write_metadata(directory, session.name, session.metadata)


def write_metadata(directory: Path, experiment: str, facts: Mapping[str, float]) -> None:
    """Write an experiment's name and facts into its bag's directory.

    Raises:
        OSError: it cannot be written.
    """
    entries = {key: {"value": float(facts[key]), "unit": FACTS[key].unit} for key in sorted(facts)}
    text = yaml.safe_dump({"experiment": experiment, "facts": entries}, sort_keys=False)
    (directory / FILE).write_text(text, encoding="utf-8")


def _tables(session: Session) -> list[tuple[Topic, tuple[str, ...], Floats]]:
    """Return (topic, labels, numbers) of what a session holds."""
    tables: list[tuple[Topic, tuple[str, ...], Floats]] = [
        (topic, AXES, session.voltages) for topic in (VALVE_COMMANDS, VALVE_VOLTAGES)
    ]
    for topic in (PRESSURES, FLOWS, SUPPLY, AUXILIARY, JOINT_STATES, ACTUATOR_STATES):
        columns = {
            label.removesuffix(POSITION): session.readings[channel]
            for channel, (where, label) in PLACES.items()
            if where is topic and session.has(channel)
        }
        if columns:
            values = np.column_stack(list(columns.values()))
            moves = topic in (JOINT_STATES, ACTUATOR_STATES)
            tables.append((topic, tuple(columns), _motion(values, session.period) if moves else values))
    return tables


def _motion(positions: Floats, period: float) -> Floats:
    """Return positions and the speeds a machine would publish; efforts, which are derived, as zero."""
    rates = np.column_stack([speeds(column, period) for column in positions.T])
    return np.hstack([positions, rates, np.zeros_like(positions)])


def read(path: Path) -> Session:
    """Read a bag as a session.

    Raises:
        SessionError: it holds no voltages, or `experiment.yaml` is not usable.
        FileNotFoundError: there is no bag.
    """
    bag = read_bag(path)
    name, facts = _experiment(path)
    base = _first_there(bag, path)
    time = bag.series(base).time_ns.astype(np.float64) * 1e-9
    time -= time[0] if len(time) else 0.0
    if len(time) < 3 or not np.all(np.diff(time) > 0.0):
        raise SessionError(f"{path}: needs three samples or more with rising stamps")
    _refuse_hole(path, base.name, np.asarray(time, dtype=np.float64))
    begin = int(bag.series(base).time_ns[0])
    period = float(np.median(np.diff(time)))
    grid = period * np.arange(round(time[-1] / period) + 1)
    try:
        volts = bag.series(VALVE_VOLTAGES)
        columns = [volts.column(axis) for axis in AXES]
    except NotInBag as error:
        raise SessionError(f"{path}: {error}") from error
    given = _given(volts.time_ns - begin, bag.sent_ns(VALVE_VOLTAGES) - begin, period)
    voltages = np.column_stack([_held(given, column, grid) for column in columns])
    readings = {}
    for channel, (topic, label) in PLACES.items():
        if bag.name(topic) is None or label not in bag.series(topic).labels:
            continue
        series = bag.series(topic)
        stamps, values = series.time_ns - begin, series.column(label)
        good = stamps[np.isfinite(values)] * 1e-9
        if len(good) > 1:  # up to the end, too: a sensor that died is not still
            _refuse_hole(path, f"{topic.name} {label}", np.append(good, max(good[-1], grid[-1])))
        readings[channel] = _at(stamps, values, grid)
    return Session(
        name=name, time=grid, voltages=voltages, readings=readings, metadata=facts, whole=bag.complete
    )


def _refuse_hole(path: Path, what: str, time: Floats) -> None:
    """Refuse a record in whose middle samples are missing; those of a slow sensor are further apart.

    Raises:
        SessionError: some are.
    """
    apart = np.diff(time)
    widest = int(np.argmax(apart))
    begin, end = time[widest], time[widest + 1]
    if end - begin > max(HOLE, SLOW * float(np.median(apart))):
        raise SessionError(
            f"{path}: a hole from {begin:.2f} to {end:.2f} s, without a sample of {what}; allowed: "
            f"holes up to {HOLE} s: record it again, or cut it into two bags"
        )


def _first_there(bag: Bag, path: Path) -> Topic:
    for topic in (PRESSURES, JOINT_STATES):
        if bag.name(topic) is not None:
            return topic
    raise SessionError(f"{path}: holds neither {PRESSURES.name} nor {JOINT_STATES.name}")


def _given(stamped: NDArray[np.int64], sent: NDArray[np.int64], period: float) -> NDArray[np.int64]:
    """Return from when on voltages hold [ns]: from the beginning of the row in which they were sent.

    Their stamps are those of the samples they answer; live they come later, on a busy computer by some rows.
    Where the clocks of stamps and publishers are two, stamps it is.
    """
    if len(sent) == 0 or abs(int(sent[0]) - int(stamped[0])) > SAME_CLOCK:
        return stamped
    width = period * 1e9
    ordered = np.maximum.accumulate(np.floor((sent + TICK) / width) * width)
    return np.asarray(np.round(ordered), dtype=np.int64)


def _held(time_ns: NDArray[np.int64], values: Floats, grid: Floats) -> Floats:
    """Return what held at the grid's times: the last value sent, zero before the first."""
    row = np.searchsorted(time_ns * 1e-9, grid + 1e-6, side="right") - 1
    return np.where(row >= 0, values[np.maximum(row, 0)], 0.0)


def _at(time_ns: NDArray[np.int64], values: Floats, grid: Floats) -> Floats:
    """Return a column at the grid's times; where stamps agree, its own samples."""
    time, good = time_ns * 1e-9, np.isfinite(values)
    if not good.any():
        return np.full(len(grid), math.nan)
    if len(time) == len(grid) and good.all() and np.allclose(time, grid, atol=1e-6):
        return values
    return np.interp(grid, time[good], values[good])


def _experiment(path: Path) -> tuple[str, dict[str, float]]:
    file = (path if path.is_dir() else path.parent) / FILE
    if not file.is_file():
        return "motion", {}
    try:
        content = read_yaml(file)
        if not isinstance(content, dict) or "experiment" not in content:
            raise ValueError("it names no experiment")
        name = str(content["experiment"])
        facts = {str(key): value(str(key), entry) for key, entry in (content.get("facts") or {}).items()}
    except (yaml.YAMLError, AttributeError, KeyError, TypeError, ValueError) as error:
        why = " ".join(str(error).split())
        raise SessionError(
            f"{file}: not usable ({why}); allowed: experiment: NAME and "
            "facts: {key: {value: 1.0, unit: m3}}"
        ) from error
    return name, facts
