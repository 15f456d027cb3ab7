"""Processes that tests start: anew, or forked from one that has imported what a node needs.

Most of what a node's start costs is imports, and the suite starts some hundred nodes. So a server that has
imported them is forked for each; all that comes after the imports is the node's own process and `main`.
A graph's supervisor that was forked so forks its nodes in turn. The demo starts all anew, as a user does.
"""

from __future__ import annotations

import contextlib
import faulthandler
import functools
import importlib
import multiprocessing
import os
import signal
import subprocess
import sys
import time
import traceback
from multiprocessing import forkserver
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from forest_bringup import supervisor

# Limits at which a test fails rather than hangs; on a busy machine a node alone takes seconds to start.
ENDED_S, TOLD_S = 60.0, 5.0
IMPORTED = (
    *("forest_control.controller_node", "forest_control.joystick_node", "forest_control.valve_driver_node"),
    *("forest_sim.simulator_node", "forest_ident.experiment_operator_node", "forest_ident.online_node"),
    "forest_ident.monitor_node",
    *("forest_bag.recorder_node", "forest_bringup.graph", "forest_station.station"),
    *("forest_station.station_node", "forest_control.cycle_node"),
    *("forest_study.demo.demo", "forest_study.cli", "forest_study.demo.replay"),
    "forest_study.experiments.forest_ident_main",
)
SERVER = multiprocessing.get_context("forkserver")
SERVER.set_forkserver_preload([*IMPORTED, "processes", "warm"])


@functools.cache
def _start_server() -> None:
    """Start the server; it finds `warm` by its environment, for of a longer path it is told too late."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(Path(__file__).parent), prepend=os.pathsep)
        forkserver.ensure_running()


class Told:
    """What tests do with a process of a session of its own, whose output goes to a file."""

    log: Path
    pid: int
    args: Any

    def text(self) -> str:
        """What it has printed so far."""
        return self.log.read_text()

    def stop(self, number: int = signal.SIGINT) -> int:
        """Ask it to stop and give its exit code; kill it if it does not."""
        if self.poll() is None:
            self.send_signal(number)
        return self.ended()

    def ended(self) -> int:
        """Wait until it ends and give its exit code; if it hangs, have it tell where, and kill it."""
        try:
            return self.wait(ENDED_S)
        except subprocess.TimeoutExpired:
            self.send_signal(signal.SIGABRT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                self.wait(TOLD_S)
            self.kill_group()
            pytest.fail(f"{self.args} did not end within {ENDED_S} s:\n{self.text()}")

    def kill_group(self) -> None:
        """Kill the whole session."""
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.pid, signal.SIGKILL)
        self.wait(ENDED_S)

    def leftover(self) -> bool:
        """Whether anything of its session still runs."""
        try:
            os.killpg(self.pid, 0)
        except ProcessLookupError:
            return False
        return True


class Process(Told, subprocess.Popen):
    """A process started anew."""

    def __init__(self, argv: list[str], log: Path, **options: Any) -> None:
        self.log = log
        with log.open("w") as output:
            super().__init__(argv, stdout=output, stderr=output, start_new_session=True, **options)


class ForkedNode(Told):
    """A module as a program, in this process's environment or another."""

    def __init__(
        self, module: str, arguments: list[str], log: Path, environment: dict[str, str] | None = None
    ) -> None:
        _start_server()
        self.log, self.args = log, [module, *arguments]
        begun, begins = SERVER.Pipe(duplex=False)
        what = (module, arguments, str(log), environment or dict(os.environ), begins)
        self._process = SERVER.Process(target=_run, args=what)
        self._process.start()
        begins.close()
        begun.recv()  # it has a session of its own
        begun.close()
        assert self._process.pid is not None
        self.pid = self._process.pid

    @property
    def returncode(self) -> int | None:
        return self._process.exitcode

    def poll(self) -> int | None:
        return self._process.exitcode

    def wait(self, timeout: float) -> int:
        self._process.join(timeout)
        if self.returncode is None:
            raise subprocess.TimeoutExpired(self.args, timeout)
        return self.returncode

    def send_signal(self, number: int) -> None:
        # Its server may have reaped it before its exit code is here.
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.pid, number)


class ForkedPopen:
    """What `subprocess.Popen` is to a supervisor that was forked itself: its node is forked from it.

    Not of a program that speaks ROS before it starts nodes: the middleware does not outlive a fork.
    """

    def __init__(self, argv: list[str], stdout: Any, env: dict[str, str], **_: Any) -> None:
        _python, _m, module, *arguments = argv
        self.returncode: int | None = None
        waits, goes = os.pipe()
        sys.stdout.flush()
        self.pid = os.fork()
        if self.pid == 0:
            _become(module, arguments, env, waits, stdout.fileno())
        os.close(waits)
        self.stdin = os.fdopen(goes, "wb")

    def poll(self) -> int | None:
        if self.returncode is None:
            ended, status = os.waitpid(self.pid, os.WNOHANG)
            self.returncode = os.waitstatus_to_exitcode(status) if ended else None
        return self.returncode

    def wait(self, timeout: float = ENDED_S) -> int:
        end = time.monotonic() + timeout
        while self.poll() is None:
            if time.monotonic() > end:
                raise subprocess.TimeoutExpired(str(self.pid), timeout)
            time.sleep(0.005)
        assert self.returncode is not None
        return self.returncode

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            os.kill(self.pid, number)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)


def _run(module: str, arguments: list[str], log: str, environment: dict[str, str], begins: Any) -> None:
    """Be the node, or the supervisor, in the process that was forked from the server."""
    os.setsid()
    output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for number in (1, 2):
        os.dup2(output, number)
    begins.send(True)
    begins.close()
    supervisor.subprocess = SimpleNamespace(  # type: ignore[attr-defined]
        Popen=ForkedPopen, PIPE=subprocess.PIPE, TimeoutExpired=subprocess.TimeoutExpired
    )
    sys.exit(_main(module, arguments, environment))


def _become(module: str, arguments: list[str], environment: dict[str, str], waits: int, output: int) -> None:
    """Be the node in a process that was forked from a supervisor, of which nothing is kept."""
    code = 1
    try:
        os.setsid()
        for number in supervisor.STOP_SIGNALS:
            signal.signal(number, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        for number, given in enumerate((waits, output, output)):
            os.dup2(given, number)
        os.closerange(3, os.sysconf("SC_OPEN_MAX"))  # the lock of the graph among them
        Path("/proc/self/comm").write_text(module.rpartition(".")[2])
        code = _main(module, arguments, environment)
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except Exception:  # noqa: BLE001  as an interpreter does at its end
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        os._exit(code)


def _main(module: str, arguments: list[str], environment: dict[str, str]) -> int:
    assert "warm" in sys.modules  # the server passes over what it cannot import
    os.environ.clear()
    os.environ.update(environment)
    faulthandler.enable()
    node = importlib.import_module(module)
    sys.argv = [str(node.__file__), *arguments]
    return node.main() or 0
