"""The closed loop with the monitor beside it, as machine code: everyday work, hour by hour.

    the operator looks at the tip -> levers -> loop_core.period -> what the sensors say -> monitor.step

The monitor reads what its topics would tell: sensors, voltages, and what the driver has learnt. Each second
a row is kept: its residuals, the tests' scores and references, the sensors' state. At some rows the machine
changes: a log, its oil, a fault.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from forest_compile import flat_layout
from forest_compile.entry import Entry
from forest_compile.kernel_cache import CachedKernel
from forest_control.config import controller_settings
from forest_control.operator import levers as levers_of
from forest_control.operator.levers import Levers
from forest_control.valve import valve_driver_parameters
from forest_control.valve.valve_adaptation import DirectionEstimate, deadband_spread, gain, gain_spread
from forest_control.valve.valve_driver import State as DriverState
from forest_description.geometry.kinematics import tip_position
from forest_description.hydraulics.valve_characteristic import Direction, ValveLaw
from forest_description.machine import load_machine
from forest_description.types import Floats, Vec3
from forest_ident.diagnosis import (
    monitor,
    monitor_readings,
    residual_limits,
    residual_parameters,
    residuals,
    sensor_watch,
)
from forest_ident.diagnosis.monitor_readings import Learnt, Readings, Way
from forest_ident.diagnosis.sequential_test import score
from forest_msgs_py.types import PERIOD
from forest_sim.sensors import sensor_suite
from forest_sim.sensors.sensor_suite import Suite
from forest_sim.sensors.signal_processing import Measurement
from forest_study.closed_loop import loop_core, loop_kernel
from forest_study.closed_loop.loop_core import Knowledge, Loop
from forest_study.closed_loop.path_guide import Hand, levers_for

EVERY = 200  # periods of a row
NEAR, APPROACH = 0.03, 1.0  # [m] a place is reached; [1/s] speed per distance before it
LED = 5  # columns of a period's work: place, speed, what the hand does
HELD, WORKS = 0.5, 0.9  # of the last column: from there the deadman is held; the levers are used
SENSORS = 3 * residuals.COUNT  # the first of their columns, behind residuals, scores, references
COLUMNS = SENSORS + monitor_readings.COUNT + 3  # and the tip
ARGUMENTS = "pppppppii"
# Where the channels of a kind begin.
FLOWS, SPOOLS = sensor_suite.PLACES["flow_meter"].start, sensor_suite.PLACES["spool_sensor"].start
CASE_DRAIN, TANK = sensor_suite.PLACES["case_drain"].start, sensor_suite.PLACES["thermocouple"].start
FROZEN, MISSING = 1.0, 2.0  # of a sensor's column
Change = Callable[[Loop, Knowledge], tuple[Loop, Knowledge]]


class Setting(NamedTuple):
    """All that a run begins with."""

    loop: Loop
    knowledge: Knowledge
    monitor: monitor.Parameters
    hand: Hand


def operated(tip: Vec3, place: Vec3, speed: float, hand: Hand) -> Levers:
    """Return the levers of an operator who wants the tip at a place [m], at most at a speed [m/s]."""
    x, y, z = place[0] - tip[0], place[1] - tip[1], place[2] - tip[2]
    distance = (x * x + y * y + z * z) ** 0.5
    if distance < NEAR:
        return levers_of.REST
    wish = min(speed, APPROACH * distance) / distance
    return levers_for((wish * x, wish * y, wish * z), hand)


def read(
    seen: Measurement, volts: Vec3, driver: DriverState, k: valve_driver_parameters.Parameters
) -> Readings:
    """Return what the monitor reads of a period."""
    one, two, three = driver.estimates
    axes = k.axes
    return Readings(
        voltages=volts,
        angles=seen.joints.position,
        lengths=(seen.actuators.position[1], seen.actuators.position[2]),
        pressures=seen.pressures,
        supply=seen.supply_pressure,
        spools=(seen.readings[SPOOLS], seen.readings[SPOOLS + 1], seen.readings[SPOOLS + 2]),
        flows=(seen.readings[FLOWS], seen.readings[FLOWS + 1]),
        case_drain=seen.readings[CASE_DRAIN],
        temperature=seen.readings[TANK],
        valves=(
            _learnt(axes[0].valve, one.forward, one.backward),
            _learnt(axes[1].valve, two.forward, two.backward),
            _learnt(axes[2].valve, three.forward, three.backward),
        ),
    )


def _learnt(law: ValveLaw, forward: DirectionEstimate, backward: DirectionEstimate) -> Learnt:
    return Learnt(_way(law.forward, forward), _way(law.backward, backward))


def _way(file: Direction, way: DirectionEstimate) -> Way:
    deadband = file.deadband_voltage + way.deadband
    return Way(deadband, gain(way), deadband_spread(way), gain_spread(way))


def sensor_state(s: sensor_watch.Sensor, fitted: int) -> float:
    """Return 0 of a sensor that is well, or `FROZEN`, or `MISSING`."""
    if sensor_watch.is_missing(s, fitted):
        return MISSING
    return FROZEN if sensor_watch.is_frozen(s) else 0.0


def run(setting: Setting, work: Floats, normals: Floats, changes: Mapping[int, Change]) -> Floats:
    """Return a row for each second [N, COLUMNS].

    Args:
        setting: the beginning.
        work: of each period: place [m], speed [m/s], hand (0 off the deadman, 0.7 on it, 1 on the levers).
        normals: draws of the sensors [periods, channels].
        changes: what happens to the machine before which periods.
    """
    loop, k = setting.loop, setting.knowledge
    state, watch = _flat("loop", loop), _flat("state", monitor.BEGIN)
    known, told = _flat("knowledge", k), _flat("parameters", (setting.monitor, setting.hand))
    recorded = np.full((len(work) // EVERY, COLUMNS), np.nan)
    parts = (state, known, watch, told, np.ascontiguousarray(work), normals, recorded)
    pointers, kernel, begun = [part.ctypes.data for part in parts], KERNEL.kernel(), 0
    for row in (*sorted(changes), len(work)):
        kernel(*pointers, begun, row)
        begun = row
        if row in changes:
            loop = flat_layout.unpacker(_examples()["loop"])(state.tolist())
            loop, k = changes[row](loop, k)
            state[:], known[:] = _flat("loop", loop), _flat("knowledge", k)
    return recorded


@lru_cache(maxsize=8)
def _packer(kind: str) -> Callable[[Any], flat_layout.Row]:
    return flat_layout.packer(_examples()[kind])


def _flat(kind: str, value: Any) -> Floats:
    return np.array(_packer(kind)(value), dtype=np.float64)


def draws(suite: Suite, rows: int) -> Floats:
    """Return a run's draws [rows, channels]; one generator, told all at once."""
    generator = sensor_suite.noise_generator(suite, "diagnosis")
    drawn = generator.standard_normal((rows, len(sensor_suite.DRAWN)))
    return np.take(drawn, sensor_suite.DRAW_OF, axis=1)


@lru_cache(maxsize=1)
def _examples() -> dict[str, Any]:
    """Return values of the types that all runs share."""
    machine = load_machine("c180")
    suite = sensor_suite.sensor_suite(machine)
    settings = controller_settings.Settings(), valve_driver_parameters.Settings()
    k = loop_kernel.knowledge(machine, machine, *settings, suite)
    loop = loop_kernel.begin(k, (0.0, 0.5, -1.5), suite)
    p = monitor.Parameters(residual_parameters.parameters(machine), residual_limits.LIMITS)
    return {"loop": loop, "knowledge": k, "state": monitor.BEGIN, "parameters": (p, Hand(1.0))}


def _entry() -> Entry:
    given = _examples()
    names: dict[str, Any] = {"period": loop_core.period, "sensed": loop_core.sensed, "moved": loop_core.moved}
    names |= {f.__name__: f for f in (operated, read, sensor_state, score, Levers)}
    names |= {"watched": monitor.step, "REST": levers_of.REST, "tip_position": tip_position}
    tuples = {"k": ("knowledge", given["knowledge"]), "given": ("told", given["parameters"])}
    noinline = (*loop_kernel.NOINLINE, monitor.step)
    return Entry(text=_text(names), names=names, arguments=ARGUMENTS, tuples=tuples, noinline=noinline)


def _text(names: dict[str, Any]) -> str:
    """Return the kernel's source; names takes the types of what it makes."""
    given = _examples()
    n, m, line = residuals.COUNT, monitor_readings.COUNT, 12 * " "
    state, watch = given["loop"], given["state"]
    lines = [
        "def kernel(state, knowledge, monitor, told, work, normals, recorded, begin, end):",
        "    p, hand = given[0], given[1]",
        "    for row in range(begin, end):",
        f"        before = {flat_layout.construction(state, 'state', names)}",
        f"        watch = {flat_layout.construction(watch, 'monitor', names)}",
        f"        at, out = {LED} * row, {COLUMNS} * int(row / {EVERY})",
        "        place, doing = (work[at], work[at + 1], work[at + 2]), work[at + 4]",
        "        plant = before.simulation.plant",
        "        tip = tip_position((plant.swing.angle, plant.boom.angle, plant.stick.angle), k.links)",
        "        levers = operated(tip, place, work[at + 3], hand)",
        f"        if doing < {WORKS}:",
        "            levers = REST",
        "        sensors, seen = sensed(before, k, normals, row)",
        "        volts = before.drive.voltages",
        f"        after, happened = moved(before, sensors, seen, levers, doing > {HELD}, True, k, row)",
        f"        watch = watched(watch, read(seen, volts, after.drive, k.drive), p, {PERIOD})",
        *(f"        state[{i}] = {path}" for i, (path, _) in enumerate(flat_layout.leaves(state, "after"))),
        *(f"        monitor[{i}] = {path}" for i, (path, _) in enumerate(flat_layout.leaves(watch, "watch"))),
        "        if watch.residuals.ended == 1:",
        "            values = watch.residuals.values",
        *(
            f"{line}if values[{i}] == values[{i}]:\n{line}    recorded[out + {i}] = values[{i}]"
            for i in range(n)
        ),
        f"        if row % {EVERY} == {EVERY - 1}:",
        *(f"{line}recorded[out + {n + i}] = score(watch.tests[{i}], p.limits[{i}])" for i in range(n)),
        *(
            f"{line}recorded[out + {SENSORS + i}] = sensor_state(watch.sensors[{i}], p.machine.fitted[{i}])"
            for i in range(m)
        ),
        *(f"{line}recorded[out + {2 * n + i}] = watch.tests[{i}].mean" for i in range(n)),
        *(f"{line}recorded[out + {SENSORS + m + i}] = happened.tip[{i}]" for i in range(3)),
    ]
    return "\n".join(lines)


KERNEL = CachedKernel("diagnosis", _entry)
"""The loop with its monitor."""
