"""Taught work as a person sees it: teach, play, pause, resume; each answers with a sentence.

One button of the joystick does what waits for a person: it resumes, confirms the grapple, or plays the cycle;
pressed in motion, it pauses. Programs have a service for each.
"""

import math
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from forest_control.config.controller_settings import Parameters
from forest_control.config.setting_file import SettingFileError
from forest_control.taught import player
from forest_control.taught.cycle import CONFIRMATION, Cycle, Grapple, Pose, Segment
from forest_control.taught.cycle_file import SPEED, checked_name, load_cycle, names, save_cycle
from forest_control.taught.joint_trajectory import NAME, TrajectoryRow, trajectory_leg, trajectory_points
from forest_control.taught.plan import Leg, Step, planned
from forest_control.taught.player import Inputs, Output, Phase, State
from forest_control.taught.taught_status import Status, segment_of, status_of, waiting
from forest_control.taught.teaching import Teaching
from forest_control.taught.tip_path import PathError, load_splines
from forest_description.types import Vec3

TEACHES = {"path": "record", "pose": "pose", "close": "close", "open": "open"}  # what: by which action
BUSY = (Phase.WAITING, Phase.RUNNING, Phase.HOLDING)
SAME = 0.005  # [m] of a pose from the last one: a service that is called again adds nothing


class Seen(NamedTuple):
    """What the crane and the operator do."""

    tip: Vec3  # [m] measured
    time: float  # [s] rising
    armed: bool  # the controller lets the levers move the crane
    centred: bool  # no stick is deflected
    button: bool = False  # the one button was pressed


class Refused(Exception):
    """What was asked for cannot be; the text is one sentence."""


class TaughtWork:
    """One crane's taught work.

    Args:
        folder: of the user's cycles.
        p: the controller's parameters: what its machine and its walls allow.
    """

    def __init__(self, folder: Path, p: Parameters) -> None:
        self.cycle, self.label = "", ""  # names of the cycle, and of the next segment that is taught
        self.p = p
        self._folder = folder
        self._state, self._teaching = State(), Teaching()
        self.begun = 0  # plays, of cycles and trajectories
        self._recording = self._go = self._pause = self._end = False
        self._tip: Vec3 | None = None
        self._name = ""  # of the cycle that is played or recorded
        self._said: list[str] = []  # events that wait
        load_splines()

    @property
    def actions(self) -> dict[str, Callable[[], tuple[bool, str]]]:
        """Actions by their services' names; each gives success and a sentence."""
        verbs = (self.record, self.pose, self.close, self.open, self.stop, self.play, self.pause, self.resume)
        return {verb.__name__: _answering(verb) for verb in verbs}

    @property
    def phase(self) -> Phase:
        """What is going on."""
        return Phase.RECORDING if self._recording else self._state.phase

    @property
    def rests(self) -> bool:
        """Whether nothing is played, taught, or waits for a person."""
        return self.phase in (Phase.IDLE, Phase.FINISHED)

    @property
    def run(self) -> float:
        """Number of the run that is under way, or was the last."""
        return self._state.run

    @property
    def beside(self) -> Vec3 | None:
        """The place of the path beside the tip [m]; None: no path is played."""
        place = self._state.place
        return place and place.leg.path.at(place.way)

    @property
    def end(self) -> Vec3:
        """Where the last leg ends [m]."""
        legs = [step for step in self._state.steps if isinstance(step, Leg)]
        return legs[-1].path.at(legs[-1].path.length)

    def record(self) -> str:
        """Begin to teach a path: from here on, where the tip is driven."""
        if self._recording:
            return f"teaching a path of {self._name}"
        self._taught(self.cycle)
        self._here()
        self._recording, self._teaching, self._name = True, Teaching(), self.cycle
        return self._say(f"teaching a path of {self.cycle}: drive it, then stop")

    def pose(self) -> str:
        """Teach where the tip is as a pose."""
        taught, tip = self._taught(self.cycle), self._here()
        last = taught.segments[-1] if taught.segments else None
        if isinstance(last, Pose) and math.dist(last.tip, tip) < SAME:
            return f"{self.cycle}: {last.name} is there"
        return self._add(taught, Pose(self.label or "pose", tip, SPEED))

    def close(self) -> str:
        """Teach that the grapple closes."""
        return self._grapple("close")

    def open(self) -> str:
        """Teach that the grapple opens."""
        return self._grapple("open")

    def stop(self) -> str:
        """End what is taught, and keep it; or end what is played."""
        if self._recording:
            return self._keep_path()
        if self._state.phase in (*BUSY, Phase.PAUSED):
            self._pause = self._end = True
            return f"{self._name}: ending"
        raise Refused("nothing is taught or played; allowed: stop after record or play")

    def play(self) -> str:
        """Play the cycle from its beginning, once the deadman is held."""
        if self._recording or self._state.phase in BUSY:
            raise Refused(f"{self._name} is under way; allowed: play after stop")
        steps = planned(load_cycle(self.cycle, self._folder), self._here(), self.p)
        if not steps:
            raise Refused(f"{self.cycle}: the tip is there already; allowed: play it from elsewhere")
        return self._say(f"{self.cycle}: play, {self._begin(self.cycle, steps)}")

    def _begin(self, name: str, steps: tuple[Step, ...]) -> str:
        """Begin to play steps, and return the event."""
        run, self._name = self._state.run, name
        self.begun += 1
        self._state, event = player.started(steps)
        self._state = self._state._replace(run=run)
        return event

    def follow(self, names: Sequence[str], rows: Sequence[TrajectoryRow]) -> tuple[bool, str]:
        """Play a program's joint trajectory once the deadman is held.

        Args:
            names: of the joints, in the order of the rows' values.
            rows: points.
        """
        return _answering(partial(self._follow, names, rows))()

    def _follow(self, names: Sequence[str], rows: Sequence[TrajectoryRow]) -> str:
        points = trajectory_points(names, rows)
        if self._recording or self._state.phase in BUSY:
            raise Refused(f"{self._name} is under way; allowed: a trajectory after stop")
        leg = trajectory_leg(points, self._here(), self.p)
        self._begin(NAME, (leg,))
        times = f"{points[-1].time:.1f} s asked for, {leg.duration:.1f} s at the least"
        return self._say(f"{NAME}: {leg.path.length:.2f} m, {times}")

    def outcome(self, begun: int) -> tuple[bool, str] | None:
        """Return success and a sentence of one of the plays that were begun; None: it is not over."""
        if self.begun != begun:
            return False, "another was begun"
        ends = {Phase.FINISHED: (True, "finished"), Phase.IDLE: (False, "ended")}
        return ends.get(self._state.phase)

    def pause(self) -> str:
        """Pause; the tip stops and is held."""
        if self._state.phase not in (Phase.WAITING, Phase.RUNNING):
            raise Refused("no cycle moves the tip; allowed: pause while one does")
        self._pause = True
        return f"{self._name}: pausing"

    def resume(self) -> str:
        """Resume what is paused, or confirm the grapple, once the deadman is held."""
        if self._state.phase not in (Phase.PAUSED, Phase.HOLDING):
            raise Refused("nothing waits for a person; allowed: resume after a pause, or at a grapple")
        self._go = True
        return f"{self._name}: going on"

    def advance(self, seen: Seen, dt: float) -> Output:
        """Return what is said dt [s] later; the event is there once."""
        self._tip = seen.tip
        if self._recording:
            self._teaching.add(seen.tip, seen.time)
        if seen.button:
            self._press()
        inputs = Inputs(*seen[:4], self._go, self._pause)
        self._go = self._pause = False
        self._state, output = player.step(self._state, inputs, self.p, dt)
        if output.event:
            self._say(f"{self._name}: {output.event}")
        if self._end and self._state.phase != Phase.RUNNING:
            self._state, self._end = State(run=self._state.run), False
            self._say(f"{self._name}: ended")
        said, self._said = "; ".join(self._said), []
        return Output(output.command, said)

    def status(self) -> Status:
        """Return where the work is."""
        return Status(self.phase) if self._recording else status_of(self._state, self._tip)

    def waiting(self) -> str:
        """Return what a person is waited for; "" for nothing."""
        said = "a path is taught: drive it, then stop" if self._recording else waiting(self._state)
        return said and f"{self._name}: {said}"

    def values(self) -> dict[str, Any]:
        """Return what is done, by names, for /diagnostics."""
        segment = "" if self._recording else segment_of(self._state)
        return {"phase": self.phase.name.lower(), "cycle": self._name, "segment": segment}

    def _press(self) -> None:
        """Do what the button does."""
        phase = self._state.phase
        verb = self.pause if phase in (Phase.WAITING, Phase.RUNNING) else self.play
        verb = self.resume if phase in (Phase.PAUSED, Phase.HOLDING) else verb
        if self._recording:
            verb = self.stop
        if self._recording or phase != Phase.IDLE or self.cycle:
            _, answer = _answering(verb)()
            if answer not in self._said:
                self._say(answer)

    def _grapple(self, action: str) -> str:
        taught = self._taught(self.cycle)
        last = taught.segments[-1] if taught.segments else None
        if isinstance(last, Grapple) and last.action == action:
            return f"{self.cycle}: {last.name} is there"
        return self._add(taught, Grapple(self.label or action, action, CONFIRMATION))

    def _keep_path(self) -> str:
        """Keep the path that was driven; if its file cannot be written, it can be kept later."""
        try:
            path = self._teaching.path(self.label or "path")
        except PathError:
            self._recording = False
            raise
        said = self._add(_known(self._name, self._folder), path)
        self._recording = False
        return said

    def _add(self, taught: Cycle, segment: Segment) -> str:
        """Keep a segment in the cycle's file, at its end."""
        taught = taught.with_segment(segment)
        path = save_cycle(taught, self._folder)
        return self._say(f"{taught.name}: {taught.segments[-1].name} is taught, in {path}")

    def _taught(self, name: str) -> Cycle:
        """Return what the file of a cycle that is to be taught holds by now."""
        if self._recording or self._state.phase in BUSY:
            raise Refused(f"{self._name} is under way; allowed: to teach after stop")
        return _known(name, self._folder)

    def _here(self) -> Vec3:
        if self._tip is None:
            raise Refused("where the tip is has not been heard; allowed: with a controller that publishes it")
        return self._tip

    def _say(self, event: str) -> str:
        self._said.append(event)
        return event


def _known(name: str, folder: Path) -> Cycle:
    """Return what a cycle's file holds, also of a shipped one; of a new one, nothing."""
    return load_cycle(name, folder) if checked_name(name) in names(folder) else Cycle(name)


def _answering(verb: Callable[[], str]) -> Callable[[], tuple[bool, str]]:
    """Return an action that answers with success and a sentence."""

    def answer() -> tuple[bool, str]:
        try:
            return True, verb()
        except (Refused, SettingFileError, PathError) as error:
            return False, str(error)
        except OSError as error:
            return False, f"{error.filename}: {error.strerror}"

    return answer
