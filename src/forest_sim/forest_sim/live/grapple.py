"""What others may have the head of a running machine do: grasp a log, drop it."""

import threading
from collections.abc import Callable
from typing import Any

from forest_sim.simulation.load_schedule import Load
from forest_sim.simulation.simulated_machine import SimulatedMachine

Answer = tuple[bool, str]


class Grapple:
    """Actions for services, which come in another thread than the machine moves in.

    Args:
        machine: whose head it is.
        changing: lock under which the machine moves.
        parameter: gives those of the log that lies ready, by name.
    """

    def __init__(
        self, machine: SimulatedMachine, changing: threading.Lock, parameter: Callable[[str], Any]
    ) -> None:
        self._machine, self._changing, self._parameter = machine, changing, parameter
        self.actions: dict[str, Callable[[], Answer]] = {"grasp": self.grasp, "drop": self.drop}

    def grasp(self) -> Answer:
        """Close on a log that lies still; return whether that was possible, and a sentence."""
        log = Load(self._parameter("log_mass").value, self._parameter("log_length").value)
        with self._changing:
            held = self._machine.load
            if held.mass > 0.0:
                return False, f"the head holds a log of {held.mass:g} kg already; drop it first"
            self._machine.hold(log)
        return True, f"holds a log of {log.mass:g} kg, {log.length:g} m long"

    def drop(self) -> Answer:
        """Let go of the log; return whether there was one, and a sentence."""
        with self._changing:
            held = self._machine.load
            if held.mass == 0.0:
                return False, "the head holds no log; grasp one first"
            self._machine.hold(Load(0.0))
        return True, f"dropped a log of {held.mass:g} kg"
