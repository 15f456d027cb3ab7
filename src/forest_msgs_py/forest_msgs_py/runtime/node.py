"""The frame that every node runs in: environment, parameters, signals, last words, exit code.

===========  ===============================================================================================
exit code    meaning
===========  ===============================================================================================
0            asked to stop (SIGINT, SIGTERM, SIGHUP), or done (``Finished``)
1            an exception in a callback, or a ``NodeFailure``
2            could not start: a parameter, a name or a file is wrong
-SIGALRM     all was done, and then the middleware did not let the node go
===========  ===============================================================================================

A node that defines ``stop()`` is given its last words: it is called once, before the node is destroyed, while
publishing still works. That is why rclpy's own signal handlers, which end the context at once, stay off.

A node that defines ``run(stopping)`` keeps its own time: it is called in a thread of its own, and the
executor is left with parameters and timers. When it returns, which it does soon after the event ``stopping``
is set, the node ends; what it raises counts as raised in a callback.
"""

import difflib
import faulthandler
import gc
import re
import signal
import socket
import sys
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from types import FrameType
from typing import Any

import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.event_handler import PublisherEventCallbacks
from rclpy.exceptions import NameValidationException, ParameterException
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from forest_msgs_py.interfaces.topic_qos import qos
from forest_msgs_py.interfaces.topics import Topic, message_class
from forest_msgs_py.runtime.environment import (
    NetworkError,
    NoSupervisor,
    prepare_environment,
    wait_for_supervisor,
)
from forest_msgs_py.runtime.static_executor import StaticExecutor
from forest_msgs_py.runtime.stop_signals import heeded

ARGUMENTS = "--ros-args [-p NAME:=VALUE] [-r FROM:=TO] ... (docs/reference/parameters.md)"
SOURCE = re.compile(r",? at /\S+:\d+")  # where in rcl's own files an error arose
LAST_WORDS = 0.1  # [s]
LEAVING = 2.0  # [s] for a node to leave the graph; on a loaded host it takes up to 0.4


class NodeFailure(Exception):
    """Raised in a callback or in ``stop()``: ends the node with one clear line and exit code 1."""


class Finished(Exception):
    """Raised in a callback: the node has done what it was for; exit code 0."""


class _StopSignals:
    """Calls ``react`` when a signal to stop arrives, even while the main thread waits inside the middleware.

    Python runs a handler only when the main thread comes back from C, which an idle wait set does not do; the
    wake-up descriptor is written to at once, from whichever thread the kernel chose.
    """

    def __init__(self) -> None:
        self.requested = threading.Event()
        self.react: Callable[[], None] = lambda: None
        self._reader, self._writer = socket.socketpair()
        self._writer.setblocking(False)
        self._numbers = heeded()
        for number in self._numbers:
            signal.signal(number, self._ignore)
        signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)
        self._thread = threading.Thread(target=self._watch, name="stop-signals", daemon=True)
        self._thread.start()

    @staticmethod
    def _ignore(_number: int, _frame: FrameType | None) -> None:
        """The watching thread acts; a second or third signal must not interrupt the last words."""

    def _watch(self) -> None:
        while numbers := self._reader.recv(64):
            if any(number in self._numbers for number in numbers):
                self.requested.set()
                self.react()

    def close(self) -> None:
        """End watching. A signal that comes while the process ends must not change its exit code."""
        self.react = lambda: None
        for number in self._numbers:
            signal.signal(number, signal.SIG_IGN)
        signal.set_wakeup_fd(-1)
        self._writer.close()
        self._thread.join()
        self._reader.close()


def run_node(factory: Callable[[], Node], args: Sequence[str] | None = None) -> int:
    """Build a node, run it until it is told to stop, and give the process' exit code.

    Args:
        factory: of the node; asked for help, its module's docstring is what it says.
        args: the command line; default: that of the process.
    """
    if {"-h", "--help"} & set(sys.argv if args is None else args):
        print(f"{(sys.modules[factory.__module__].__doc__ or '').strip()}\n\nArguments: {ARGUMENTS}")
        return 0
    faulthandler.enable()  # a crash tells in the log where it was
    try:
        prepare_environment()
        wait_for_supervisor()
    except (NetworkError, NoSupervisor) as error:
        _print_error(error)
        return 2
    signals = _StopSignals()
    try:
        try:
            _start_ros(args)
            node = factory()
            _warn_of_unknown_parameters(node)
        except _start_errors() as error:
            _print_error(error)
            return 2
        gc.freeze()  # else a collection looks through all that was made at the start, for up to 0.15 s
        code = _spin(node, signals)
        if code == 0:
            _limit_leaving()
        node.destroy_node()
        return code
    finally:
        rclpy.try_shutdown()
        signals.close()


def _start_errors() -> tuple[type[BaseException], ...]:
    from rclpy._rclpy_pybind11 import RCLError

    return (ValueError, OSError, NodeFailure, ParameterException, NameValidationException, RCLError)


def _start_ros(args: Sequence[str] | None) -> None:
    """Start ROS; raise ValueError unless it understands every argument: some it passes over in silence."""
    from rclpy._rclpy_pybind11 import UnknownROSArgsError

    try:
        rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
    except UnknownROSArgsError as error:
        raise ValueError(f"unknown ROS arguments {error}; allowed: {ARGUMENTS}") from error
    others = remove_ros_args(sys.argv if args is None else list(args))[1:]
    if others:
        raise ValueError(f"unknown argument {others[0]!r}; allowed: {ARGUMENTS}")


def _warn_of_unknown_parameters(node: Node) -> None:
    """Say which parameters were given that the node does not have: ROS says nothing, a slip has no effect."""
    given: dict[str, Any] = getattr(node, "_parameter_overrides", {})
    for name in given:
        if not node.has_parameter(name) and not name.startswith("qos_overrides."):
            near = difflib.get_close_matches(name, node.get_parameters_by_prefix(""), 1)
            meant = f"; there is {near[0]!r}" if near else ""
            node.get_logger().warning(f"parameter {name!r} is not one of this node's and does nothing{meant}")


def _print_error(error: BaseException) -> None:
    told = SOURCE.sub("", " ".join(str(error).split()))
    print(f"{Path(sys.argv[0]).stem}: {told}", file=sys.stderr, flush=True)


def _spin(node: Node, signals: _StopSignals) -> int:
    """Run callbacks in this thread until a stop is asked for; exceptions in callbacks end the node."""
    executor = StaticExecutor()
    executor.add_node(node)
    wake = node.create_guard_condition(_finish)
    signals.react = wake.trigger
    if signals.requested.is_set():
        wake.trigger()
    loop = _Loop(node, wake.trigger)
    code = max(_outcome(executor.spin), loop.end())
    signals.react = lambda: None
    last_words: Callable[[], None] | None = getattr(node, "stop", None)
    if last_words is not None:
        code = max(code, _outcome(last_words))
    # What was said in a thread of the node's counts, too, as the last batch of a lockstep run.
    _wait_for_acknowledgement(node)
    executor.shutdown(timeout_sec=0.0)
    return code


def _limit_leaving() -> None:
    """Have the kernel end the process if it does not end by itself.

    Fast DDS can deadlock while a participant goes (its issue 6502), with Python's interpreter locked: no
    thread of ours could act. The others miss such a node when its lease has run out.
    """
    signal.setitimer(signal.ITIMER_REAL, LEAVING)


class _Loop:
    """Runs ``node.run`` beside the executor, if the node has it; ``wake`` is called when it has ended."""

    def __init__(self, node: Node, wake: Callable[[], None]) -> None:
        self._stopping = threading.Event()
        self._code, self._wake = 0, wake
        self._thread: threading.Thread | None = None
        run: Callable[[threading.Event], None] | None = getattr(node, "run", None)
        if run is not None:
            self._thread = threading.Thread(target=self._main, args=(run,), name="loop", daemon=True)
            self._thread.start()

    def _main(self, run: Callable[[threading.Event], None]) -> None:
        self._code = _outcome(lambda: run(self._stopping))
        self._wake()

    def end(self) -> int:
        """Have it stop, wait until it has, and give its code."""
        self._stopping.set()
        if self._thread is not None:
            self._thread.join()
        return self._code


def _wait_for_acknowledgement(node: Node) -> None:
    """Give the last words time to arrive: readers drop what a vanished writer had in flight."""
    end = time.monotonic() + LAST_WORDS
    for sender in node.publishers:
        left = max(0.0, end - time.monotonic())
        sender.wait_for_all_acked(Duration(seconds=left))


def _finish() -> None:
    raise Finished


def _outcome(run: Callable[[], None]) -> int:
    try:
        run()
    except (KeyboardInterrupt, ExternalShutdownException, Finished):
        return 0
    except NodeFailure as error:
        _print_error(error)
        return 1
    except Exception:  # noqa: BLE001  whatever it was, the last words come next
        traceback.print_exc()
        return 1
    return 0


def timer(node: Node, period: float, callback: Callable[[], None]) -> Any:
    """A timer [s] on the steady clock: no watchdog stops because somebody set, or simulates, the time."""
    return node.create_timer(period, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))


def publisher(node: Node, topic: Topic) -> Any:
    """A publisher with the type and the QoS of the table.

    Without rclpy's own event handlers: it looks through all of them at every wake-up, which costs a node with
    ten publishers more than its work. A reader with another QoS is still told by its own side.
    """
    silent = PublisherEventCallbacks(use_default_callbacks=False)
    return node.create_publisher(message_class(topic), topic.name, qos(topic), event_callbacks=silent)


def raw_publish(publisher: Any) -> Callable[[bytes], None]:
    """The call that publishes bytes, without what rclpy does in Python before.

    Not to be called beside or after the publisher's end; a node's threads end before its publishers.
    """
    call: Callable[[bytes], None] = publisher.handle.publish_raw
    return call


def subscription(node: Node, topic: Topic, callback: Callable[..., None], raw: bool = False) -> Any:
    """A subscription with the type and the QoS of the table; `raw`: of bytes instead of messages."""
    profile = qos(topic, reading=True)
    return node.create_subscription(message_class(topic), topic.name, callback, profile, raw=raw)
