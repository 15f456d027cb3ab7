"""A live crane whose levers never rest until they are centred on purpose, and all that it says meanwhile.

time [s] from the joystick's first sample | levers, deadman held
0 .. BEGUN                                | at rest: they arm, once all nodes are there
.. REST                                   | deflected, rocking: the fault begins and heals here
.. AGAIN                                  | at rest: the deliberate act
.. ENDS                                   | deflected again
then                                      | the last two once more, and again: `ACTS` in all

A computer that keeps the machine's state back for 0.1 s in an act disarms the levers, as it should. So a
person who finds the crane standing centres them again. That one act is enough offline runs claim.
"""

from __future__ import annotations

import math
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from graph_processes import NODES, alive, nodes_of
from rclpy.qos import QoSProfile, ReliabilityPolicy
from shouter import SHOUTED, STANDS
from stall import Stall

from forest_bringup.graph import graph_nodes, parse_options
from forest_control.operator.joystick_sources import LEAD_IN
from forest_description.geometry.kinematics import tip_position
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import read_joint_state
from forest_msgs_py.interfaces.topics import Topic, message_class
from forest_msgs_py.runtime.polled_subscription import PolledSubscription
from forest_msgs_py.serialization.unpacking import ArrayReader

MACHINE = "c180"
LINKS = load_machine(MACHINE).manipulator.links
STRANGERS = tip_position(STANDS, LINKS)
BEGUN, REST, AGAIN, ENDS = 2.5, 7.0, 7.8, 9.3  # [s]
ACTS = 3
LATEST = 4.8  # [s] for a fault to begin
KEPT, A_SECOND = 5000, 200  # messages; of the machine's state
MET = 30.0  # [s]
PLAYING = re.compile(r"\[(\d+\.\d+)\] \[joystick\]: playing for")
Rows = list[tuple[float, Any]]  # when it was sent [s, time.time], and what


def write_levers(
    path: Path,
    begun: float = BEGUN,
    rest: float = REST,
    again: float = AGAIN,
    ends: float = ENDS,
    acts: int = 1,
) -> Path:
    """Write the levers: the swing's rocks, the stick's stays deflected, so that they are never centred."""
    rows = []
    for k in range(round((rest + acts * (ends - rest) - LEAD_IN) / 0.1)):
        time_s = LEAD_IN + k / 10
        of_act = time_s if time_s < ends else rest + (time_s - ends) % (ends - rest)
        goes = begun <= of_act < rest or of_act >= again
        rows.append(f"{k / 10:.1f},{0.4 * math.sin(math.pi * k / 10) * goes:.4f},0,{0.1 * goes}")
    path.write_text("\n".join(["time_s,swing,boom,stick", *rows, ""]))
    return path


class Ears:
    """What the topics say, kept by the middleware until it is read: nobody has to spin in time."""

    def __init__(self, node: Any) -> None:
        # Best effort: a reliable reader waits for what a dead writer will never repeat.
        loose = QoSProfile(depth=KEPT, reliability=ReliabilityPolicy.BEST_EFFORT)
        self._ears = {
            topic: PolledSubscription(node, message_class(topic), topic.name, loose, raw=raw)
            for topic, raw in (
                (topics.VALVE_VOLTAGES, True),
                (topics.JOINT_STATES, False),
                (topics.DIAGNOSTICS, False),
            )
        }
        self._volts = ArrayReader(topics.VALVE_VOLTAGES)
        self.volts, self.tips, self.told = Rows(), Rows(), Rows()
        self.lost, self._count = 0, 0

    def read(self) -> bool:
        """Take what has come; always true, to stand before a condition."""
        for data, info in self._taken(topics.VALVE_VOLTAGES):
            self.volts.append((info["source_timestamp"] * 1e-9, self._volts.read(data, 0).values))
        for message, info in self._taken(topics.JOINT_STATES):
            angles = read_joint_state(topics.JOINTS, message).values.position
            self.tips.append((info["source_timestamp"] * 1e-9, tip_position(angles, LINKS)))
            self._number(info["publication_sequence_number"])
        for message, info in self._taken(topics.DIAGNOSTICS):
            for status in message.status:
                if status.level != b"\0" and status.message:
                    self.told.append((info["source_timestamp"] * 1e-9, f"{status.name}: {status.message}"))
        return True

    def _taken(self, topic: Topic) -> Iterator[tuple[Any, dict[str, int]]]:
        return self._ears[topic].take()

    def _number(self, number: int) -> None:
        """Count what is missing of the machine's state; who is started anew, or is another, counts anew."""
        missing = number - self._count - 1
        self.lost += missing if self._count and 0 < missing < A_SECOND else 0
        self._count = number


class Outcome(NamedTuple):
    """What came of a fault."""

    zero: float  # [s] from the fault to the last open voltage before it heals; infinite: it moves on
    waited: float  # [s] that threads of the graph, and of us, waited for a processor meanwhile, in sum
    way: float  # [m] of the tip from the fault until half a second after zero; NaN: nobody told it
    told: tuple[str, ...]  # on /diagnostics and in the graph's log, from the fault on
    restarted: bool  # open again between healing and the deliberate act
    again: bool  # open after it
    lost: int  # messages of the machine's state
    code: int | None  # exit code of the graph; None: no supervisor was there
    orphans: tuple[str, ...]
    traceback: bool


class LiveCrane:
    """The processes of a crane, and what they say.

    Args:
        start: fixture `start_process`.
        ears: on the topics.
        folder: for levers and bag.
    """

    def __init__(self, start: Callable[..., Any], ears: Ears, folder: Path) -> None:
        self.start, self.ears, self.folder = start, ears, folder
        levers = write_levers(folder / "levers.csv", acts=ACTS)
        self._words = "--machine", MACHINE, "--joystick", str(levers), "--record", str(folder / "bag")
        self.specs = {spec.name: spec for spec in graph_nodes(parse_options(self._words))}
        self.graph: Any = None
        self.processes: dict[str, Any] = {}  # started by hand, the newest of each name
        self._everyone: list[Any] = []
        self._stall, self._fault, self._logged = Stall(), math.inf, 0

    def start_graph(self) -> None:
        """Start all nodes under the supervisor."""
        self.graph = self.start(["-m", "forest_bringup.graph", *self._words])
        self._everyone.append(self.graph)
        self.until(lambda: self.graph.poll() is None and set(self.pids()) == set(NODES))

    def start_node(self, name: str, *more: str) -> None:
        """Start a node by hand."""
        spec = self.specs[name]
        self.processes[name] = self.start(["-m", spec.module, "--ros-args", *spec.arguments, *more])
        self._everyone.append(self.processes[name])

    def pids(self) -> dict[str, int]:
        """Return the process numbers of the nodes that run."""
        started = {name: process.pid for name, process in self.processes.items() if process.poll() is None}
        return (nodes_of(self.graph) if self.graph else {}) | started

    def until(self, condition: Callable[[], Any], seconds: float = MET) -> None:
        """Wait for a condition."""
        end = time.monotonic() + seconds
        while not (self._stall.look() and self.ears.read() and condition()):
            assert time.monotonic() < end, self.text()
            time.sleep(0.01)

    def until_time(self, seconds: float) -> None:
        """Wait until a time since the joystick's first sample [s]; it waits for that."""
        self.until(lambda: time.time() >= self.played() + seconds, MET + ENDS)

    def played(self) -> float:
        """Return when the joystick began to play [s, time.time]; infinite: it has not."""
        found = PLAYING.search(self.text())
        return float(found[1]) if found else math.inf

    def until_moving(self) -> None:
        """Wait until the valves are open, early enough that what follows is over before the levers rest."""
        latest = self.played() + LATEST
        self.until(lambda: self._opened_at() > 0.0 or time.time() >= latest)
        assert time.time() < latest, f"the computer is too slow:\n{self.text()}"

    def until_acted(self) -> None:
        """Wait until it moves after a deliberate act, or all acts are over."""
        over = REST + ACTS * (ENDS - REST) - 0.3  # before the joystick has played to its end
        self.until(
            lambda: self._opened_at() >= self.played() + AGAIN or time.time() >= self.played() + over,
            MET + over,
        )

    def _opened_at(self) -> float:
        """Return when the newest voltages, that open a valve, were sent [s, time.time]; -inf: they do not."""
        at, volts = self.ears.volts[-1] if self.ears.volts else (0.0, ())
        return at if any(volts) else -math.inf

    def begin(self) -> None:
        """Note that the fault begins here."""
        self._fault, self._logged = time.time(), len(self.text())
        own = [self.graph.pid] if self.graph else []
        self._stall = Stall(*own, *self.pids().values())

    def text(self) -> str:
        """Return what the processes have printed."""
        return "\n".join(process.text() for process in self._everyone)

    def end(self, healed: float) -> Outcome:
        """Stop everything, and tell what came of a fault that has healed [s, time.time].

        Args:
            healed: when; later than the deliberate act: it never does.
        """
        pids = self.pids()
        if self.graph:
            self.graph.stop()
        for process in self._everyone:
            process.stop()
        self.ears.read()
        act = self.played() + REST
        opened = [at for at, volts in self.ears.volts if any(volts) and volts != SHOUTED]
        meanwhile = [at for at in opened if self._fault <= at < min(healed, act)]
        last = max(meanwhile, default=self._fault)
        stops = last < min(healed, act) - 0.2
        since = self._fault - 0.02
        tips = [tip for at, tip in self.ears.tips if since <= at < last + 0.5 and tip != STRANGERS]
        here = time.monotonic() - time.time()
        told = [said for at, said in self.ears.told if at >= self._fault]
        return Outcome(
            zero=last - self._fault if stops else math.inf,
            waited=self._stall.seconds(until=last + here),
            way=float(np.linalg.norm(np.subtract(tips, tips[0]), axis=1).max()) if tips else math.nan,
            told=tuple(dict.fromkeys([*self.text()[self._logged :].splitlines(), *told])),
            restarted=stops and any(healed + 0.05 <= at < act for at in opened),
            again=any(at >= self.played() + AGAIN for at in opened),
            lost=self.ears.lost,
            code=self.graph.returncode if self.graph else None,
            orphans=tuple(name for name, pid in pids.items() if alive(pid)),
            traceback="Traceback" in self.text(),
        )
