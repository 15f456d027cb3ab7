"""Processes that tests start: anew, or forked from one that has imported what a node needs.

Most of what a node's start costs is imports, and the suite starts some hundred nodes. So a server that has
imported them is forked for each; all that comes after the imports is the node's own process and `main`.
"""

from __future__ import annotations

import contextlib
import faulthandler
import importlib
import multiprocessing
import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

# Limits at which a test fails rather than hangs; on a busy machine a node alone takes seconds to start.
ENDED_S, TOLD_S = 60.0, 5.0
PORT_TAKEN = "RTPS_TRANSPORT_SHM"
FORKED = (
    *("forest_control.controller_node", "forest_control.joystick_node", "forest_control.valve_driver_node"),
    *("forest_sim.simulator_node", "forest_ident.experiment_operator_node", "forest_ident.online_node"),
)
SERVER = multiprocessing.get_context("forkserver")
SERVER.set_forkserver_preload([*FORKED, "diagnostic_msgs.msg", "std_srvs.srv"])


class Told:
    """What tests do with a process of a session of its own, whose output goes to a file."""

    log: Path
    pid: int
    args: Any

    def text(self) -> str:
        """What it has printed so far, without the middleware's word for a port that is another run's.

        Participants of all domains try the same shared-memory ports in turn (fastrtps_port7000 on); one that
        just ends, or is frozen, makes them say "Failed init_port", and they take the next.
        """
        return "".join(line for line in self.log.read_text().splitlines(True) if PORT_TAKEN not in line)

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
    """A node of `FORKED`, with the environment that this process has now."""

    def __init__(self, module: str, arguments: list[str], log: Path) -> None:
        self.log, self.args = log, [module, *arguments]
        begun, begins = SERVER.Pipe(duplex=False)
        what = (module, arguments, str(log), dict(os.environ), begins)
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
        if self.poll() is None:
            os.kill(self.pid, number)


def _run(module: str, arguments: list[str], log: str, environment: dict[str, str], begins: Any) -> None:
    """Be the node, in the forked process."""
    os.setsid()
    output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
    for number in (1, 2):
        os.dup2(output, number)
    os.environ.clear()
    os.environ.update(environment)
    faulthandler.enable()
    begins.send(True)
    begins.close()
    node = importlib.import_module(module)
    sys.argv = [str(node.__file__), *arguments]
    sys.exit(node.main())
