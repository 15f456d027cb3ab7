"""The one process supervisor: starts the graph's nodes, watches them, and ends them together.

What it promises:

- One graph per ROS domain and namespace.
- A needed node ends unasked: the valves go to zero, the other nodes are stopped, and `GraphError` names the
  node and the reason. The supervisor publishes that zero itself, since the driver may be the node that died.
- A node that is not needed (the recorder) ends: a warning says so, and the graph goes on.
- Nodes are stopped from the operator towards the recorder, so that a bag ends with a machine at rest.
- A node that hangs is not found before the stop: who misses its messages stops the crane, by its timeout.
- No orphans: a stopped node has 5 s before it is killed, and nodes end with their parent, even a killed one.
"""

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, NamedTuple, cast

from forest_bringup.graph_lock import AlreadyRunning, GraphError, only_graph
from forest_bringup.process_priority import raise_priority
from forest_msgs_py.runtime.environment import PARENT_VARIABLE, prepare_environment
from forest_msgs_py.runtime.stop_signals import heeded

if TYPE_CHECKING:
    from forest_bringup.graph_monitor import GraphMonitor

STOP_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)
POLL = 0.01  # [s]
GRACE = 5.0  # [s] between SIGTERM and SIGABRT
LAST_REPORT = 0.5  # [s] between SIGABRT and SIGKILL, in which a node says where it hangs
DISCOVERY = 0.6  # [s] in which another graph in the domain can show itself before ours starts
LOOK_PERIOD = 1.0  # [s] between later looks
COMMANDING = ("joystick", "station", "experiment_operator", "controller", "valve_driver")
COULD_NOT_START = 2  # exit code
LAST_ZERO = 0.1  # [s] for which a driver that was told to stop may say its own zero first
CRASH = "Fatal Python error"  # begins where the threads were, which stays in the log
ZERO_TIME = 0.3  # [s] for which the supervisor repeats zero voltage after a death


class Stopped(Exception):
    """The user asked to stop."""


class NodeSpec(NamedTuple):
    """A node to start: its ROS name, module, ROS arguments; is it needed by others, must it be in time."""

    name: str
    module: str
    arguments: tuple[str, ...] = ()
    needed: bool = True
    urgent: bool = False


class _Process(NamedTuple):
    spec: NodeSpec
    popen: subprocess.Popen[bytes]
    log: Path
    tail: IO[str]

    @property
    def go(self) -> IO[bytes]:
        """Where a byte releases it."""
        return cast("IO[bytes]", self.popen.stdin)

    @property
    def exit_code(self) -> int:
        """Of a process that has ended. Whom the middleware did not let go had done all (`runtime.node`)."""
        code: int = self.popen.returncode
        return 0 if code == -signal.SIGALRM else code


class Supervisor:
    """A running graph; use as a context manager, which always leaves no process behind.

    Args:
        nodes: in the order in which they are to be stopped.
        namespace: of the graph, "/" or "/name".
        log_directory: one log file per node goes there.
        may_publish: publish zero voltage when a node dies; False where nothing may be published (shadow).
        on_log_line: gets every line that a node logs.
        exclusive: one graph per domain and namespace; False: these nodes join one that is running.
    """

    def __init__(
        self,
        nodes: Sequence[NodeSpec],
        namespace: str,
        log_directory: Path,
        may_publish: bool = True,
        on_log_line: Callable[[str], None] | None = None,
        exclusive: bool = True,
    ) -> None:
        self.exit_codes: dict[str, int] = {}
        self.peak_memory_mb: dict[str, float] = {}
        self._specs, self._namespace, self._logs = nodes, namespace, log_directory
        self._may_publish, self._on_log_line, self._exclusive = may_publish, on_log_line, exclusive
        self._processes: list[_Process] = []
        self._stop_requested = False
        self._next_look = 0.0
        self._finished: set[str] = set()  # nodes that ended by themselves, as they should
        self._stack = contextlib.ExitStack()
        self._monitor: GraphMonitor
        self._publish_zero: Callable[[], None] = lambda: None
        self._warned: set[str] = set()
        self._crashed: set[str] = set()  # names of nodes

    def __enter__(self) -> "Supervisor":
        """Claim the domain and start every node.

        Raises:
            GraphError: another graph is running, or a node cannot be started.
            Stopped: a signal arrived meanwhile.
        """
        with contextlib.ExitStack() as undo:
            undo.callback(self._stack.close)
            self._catch_signals()
            if self._exclusive:
                self._stack.enter_context(only_graph(self._namespace))
            self._stack.callback(self.stop)
            for spec in self._specs:
                self._start(spec)
            self._monitor = self._join_ros()
            self._publish_zero = self._monitor.publish_zero
            self._refuse_other_graph()
            self._release()
            undo.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop what still runs."""
        self.stop()
        self._stack.close()

    def run(self, until: str | None = None, progress: Callable[[], None] | None = None) -> None:
        """Watch the graph until the node `until` has finished by itself, or forever; called again, go on.

        Raises:
            GraphError: a node that is needed ended unasked.
            Stopped: the user asked to stop.
        """
        while not self._stop_requested:
            for process in self._processes:
                if process.popen.poll() is None or process.spec.name in self._finished:
                    continue
                code = process.exit_code
                if process.spec.name == until and code == 0:
                    self._finished.add(until)
                    return
                self._handle_exit(process, code)
            self._check_graph()
            self._forward_logs()
            if progress is not None:
                progress()
            time.sleep(POLL)
        raise Stopped

    def stop(self) -> None:
        """Stop every node, in order; after this nothing runs. Who ends badly is named."""
        for process in self._processes:
            self._record_memory(process)
        alive = [process for process in self._processes if process.popen.poll() is None]
        self._stop_commanding_nodes()
        hung = False
        for process in self._processes:
            if process.spec.name not in COMMANDING and process.popen.poll() is None:
                process.popen.send_signal(signal.SIGTERM)
            hung = not _wait_or_kill(process.popen) or hung
            code = process.exit_code
            # Who still loads when told to stop has no handler yet: it ends as it was told.
            self.exit_codes[process.spec.name] = 0 if code == -signal.SIGTERM else code
            if self.exit_codes[process.spec.name] and process in alive:
                print(f"warning: {_exit_report(process, code)}", file=sys.stderr, flush=True)
        if hung:
            self._zero_voltage()  # it may have been the driver, without last words
        self._forward_logs()
        for process in self._processes:
            process.tail.close()
            with contextlib.suppress(BrokenPipeError):
                process.go.close()
        self._processes = []

    def _start(self, spec: NodeSpec) -> None:
        """Start a node's process, which loads and then waits to be released."""
        if self._stop_requested:
            raise Stopped
        self._logs.mkdir(parents=True, exist_ok=True)
        log = self._logs / f"{spec.name}.log"
        arguments = ("--ros-args", "-r", f"__ns:={self._namespace}", *spec.arguments)
        prepare_environment()
        with log.open("wb") as sink:
            popen = subprocess.Popen(
                [sys.executable, "-m", spec.module, *arguments],
                stdin=subprocess.PIPE,
                stdout=sink,
                stderr=sink,
                env={**os.environ, PARENT_VARIABLE: str(os.getpid())},
                start_new_session=True,  # a Ctrl-C reaches the supervisor alone, which keeps the order
            )
        if spec.urgent:
            raise_priority(popen.pid)
        self._processes.append(_Process(spec, popen, log, log.open(encoding="utf-8", errors="replace")))

    def _join_ros(self) -> "GraphMonitor":
        """Join the ROS graph; imported here, so that the nodes load meanwhile."""
        from forest_bringup.graph_monitor import GraphMonitor

        monitor = GraphMonitor(self._namespace, self._may_publish)
        self._stack.callback(monitor.close)
        return monitor

    def _release(self) -> None:
        """Let the waiting nodes go on."""
        for process in self._processes:
            with contextlib.suppress(BrokenPipeError):  # it has ended already: `run` will say so
                process.go.write(b"\n")
                process.go.flush()

    def _handle_exit(self, process: _Process, code: int) -> None:
        """Go on without a node that is not needed, and say so once; end the graph without another.

        Raises:
            GraphError: the node is needed, or could not even start.
        """
        if process.spec.needed or code == COULD_NOT_START:
            self._end_at_zero()
            raise GraphError(_exit_report(process, code))
        if process.spec.name not in self._warned:
            self._warned.add(process.spec.name)
            text = f"warning: {_exit_report(process, code)}; the graph goes on without it"
            print(text, file=sys.stderr, flush=True)

    def _end_at_zero(self) -> None:
        """Bring the valves to zero, then stop everything."""
        self._stop_commanding_nodes()  # or a living driver would contradict the zero
        self._await_driver()
        self._zero_voltage()
        self.stop()
        self._zero_voltage()  # again, for a reader that discovered the monitor only meanwhile

    def _stop_commanding_nodes(self) -> None:
        """Have the commanding nodes publish zero and stop, all at once: none shall miss another."""
        for process in self._processes:
            if process.spec.name in COMMANDING and process.popen.poll() is None:
                process.popen.send_signal(signal.SIGTERM)

    def _await_driver(self) -> None:
        """Let a living driver end, for a while: two who talk by turns would be taken for rivals."""
        end = time.monotonic() + LAST_ZERO
        driver = [process.popen for process in self._processes if process.spec.name == "valve_driver"]
        while any(popen.poll() is None for popen in driver) and time.monotonic() < end:
            time.sleep(POLL)

    def _zero_voltage(self) -> None:
        """Publish zero on /valve_voltages for a while: the driver may be the node that died."""
        end = time.monotonic() + ZERO_TIME
        while time.monotonic() < end:
            self._publish_zero()
            time.sleep(POLL)

    def _record_memory(self, process: _Process) -> None:
        """Keep the most that a look has found a node to hold of its own [MB].

        Pages of files, of libraries above all, are left out: the nodes share them, and how many of them a
        process has mapped depends on what the kernel has in its cache.
        """
        name = process.spec.name
        with contextlib.suppress(OSError, StopIteration, ValueError):
            lines = Path(f"/proc/{process.popen.pid}/status").read_text(encoding="utf-8").splitlines()
            own = next(line for line in lines if line.startswith("RssAnon:"))
            own_mb = round(int(own.split()[1]) / 1024, 1)
            self.peak_memory_mb[name] = max(own_mb, self.peak_memory_mb.get(name, 0.0))

    def _forward_logs(self) -> None:
        for process in self._processes:
            for line in process.tail:
                if line.startswith(CRASH):
                    self._crashed.add(process.spec.name)
                if self._on_log_line is not None and process.spec.name not in self._crashed:
                    self._on_log_line(line.rstrip("\n"))

    def _catch_signals(self) -> None:
        for number in heeded(STOP_SIGNALS):
            before = signal.signal(number, self._request_stop)
            self._stack.callback(signal.signal, number, before)

    def _request_stop(self, _number: int, _frame: object) -> None:
        self._stop_requested = True

    def _refuse_other_graph(self) -> None:
        """Raise GraphError if a node of ours already runs in this domain and namespace."""
        end = time.monotonic() + DISCOVERY
        while time.monotonic() < end:
            if others := self._present_more_than(0):
                raise AlreadyRunning(self._namespace, f"node {others[0]}")
            if self._stop_requested:
                raise Stopped
            time.sleep(POLL)

    def _check_graph(self) -> None:
        """Now and then: end the graph if somebody runs a node of ours, too; warn of rivals; note the memory.

        Raises:
            AlreadyRunning: two nodes that command one crane are one too many.
        """
        if time.monotonic() < self._next_look:
            return
        self._next_look = time.monotonic() + LOOK_PERIOD
        if others := self._present_more_than(1):
            self._end_at_zero()
            raise AlreadyRunning(self._namespace, f"a second node {others[0]}")
        if self._exclusive and (topic := self._monitor.other_publisher()) and topic not in self._warned:
            self._warned.add(topic)
            print(f"warning: somebody else publishes {topic}, too", file=sys.stderr, flush=True)
        for process in self._processes:
            self._record_memory(process)

    def _present_more_than(self, count: int) -> list[str]:
        """Return names of needed nodes that the namespace holds more often than this."""
        needed = [spec.name for spec in self._specs if spec.needed]
        return [name for name in needed if self._monitor.count(name) > count]


def _exit_report(process: _Process, code: int) -> str:
    """Which node ended, how, and what it said last."""
    name = process.spec.name
    if code < 0:
        crashed = code in (-signal.SIGABRT, -signal.SIGSEGV)
        where = f"; where it was is at the end of {process.log}" if crashed else ""
        return f"{name} was killed by {_signal_name(-code)}{where}"
    log = process.log.read_text(encoding="utf-8", errors="replace").strip().splitlines()
    last = [line for line in log if "[INFO]" not in line][-1:]
    return f"{name} ended with exit code {code}" + (f": {last[0].strip()}" if last else "")


def _signal_name(number: int) -> str:
    """Return the name of a signal; most of the real-time ones have none."""
    known = number in set(signal.Signals)
    return signal.Signals(number).name if known else f"signal {number}"


def _wait_or_kill(popen: "subprocess.Popen[bytes]") -> bool:
    """Wait for a process that was told to stop; False if it hung and had to be killed.

    SIGABRT before SIGKILL: a node's log then ends with where each of its threads hung.
    """
    if _ends_within(popen, GRACE):
        return True
    popen.send_signal(signal.SIGABRT)
    if not _ends_within(popen, LAST_REPORT):
        popen.kill()
        popen.wait()
    return False


def _ends_within(popen: "subprocess.Popen[bytes]", seconds: float) -> bool:
    try:
        popen.wait(seconds)
    except subprocess.TimeoutExpired:
        return False
    return True
