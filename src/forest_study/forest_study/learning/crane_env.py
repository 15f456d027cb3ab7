"""The Gymnasium environment of the closed loop: `ForestCrane-v0`.

    gymnasium.make("forest_study.learning.crane_env:ForestCrane-v0", task="path", actions="tip")

An episode lasts 20 s, 1000 steps of 20 ms, and is then truncated; it never terminates. Tasks and rewards:
`tasks`; actions: `driven_crane`. An observation is what sensors, the task and the last action tell:

| numbers | observation | unit |
|---|---|---|
| 0..2 | measured joint angles: swing, boom, stick | rad |
| 3..5 | measured joint rates | rad/s |
| 6..11 | measured pressures of ports 1 and 2: swing, boom, stick; 0 where none is measured | MPa |
| 12..14 | true place of the tip, as a person sees it: x ahead, y to the left, z up | m |
| 15..17 | the last action | 1 |
| 18.. | path: from the tip to the ideal point, its velocity, its place in 0.25, 0.5 and 1 s | m, m/s |
| 18..20 | reach: from the tip to the target | m |

Equal seeds draw equal tasks, sensor noise and machines, whatever the actions.
"""

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from forest_description.derived.limits import pose_at
from forest_description.machine import Machine, load_machine
from forest_msgs_py.types import PERIOD
from forest_study.closed_loop import model_mismatch
from forest_study.learning import driven_crane, tasks
from forest_study.learning.driven_crane import PERIODS, DrivenCrane, LeverCrane, Sensed, ValveCrane
from forest_study.learning.tasks import Entry, Task
from forest_study.tracking.tracking import noisy

STEPS = 1000  # of an episode
MEGA = 1e6  # [Pa] of a megapascal
DRAWN = 2**31  # seeds of noise and machine
MACHINE = (
    Entry("measured joint angles", "rad", 3, 7.0),
    Entry("measured joint rates", "rad/s", 3, 10.0),
    Entry("measured pressures", "MPa", 6, 100.0),
    Entry("true place of the tip", "m", 3, tasks.FAR),
    Entry("the last action", "1", 3, 1.0),
)
Numbers = NDArray[np.float32]


class CraneEnv(gymnasium.Env[Numbers, Numbers]):
    """A crane with a task.

    Args:
        task: path or reach.
        actions: tip, joint or voltages.
        machine: shipped under a name, from a file, or as it is loaded.
        mismatch: the simulated machine is drawn anew in each episode: valves, head, spools.

    Raises:
        ValueError: task or actions are none of these.
        MachineError: the machine is not usable.
    """

    metadata = {"render_modes": [], "render_fps": round(1.0 / (PERIODS * PERIOD))}  # noqa: RUF012  Gymnasium's

    def __init__(
        self,
        task: str = "path",
        actions: str = "tip",
        machine: Machine | str = "c180",
        mismatch: bool = False,
    ) -> None:
        for given, known in ((task, tasks.NAMES), (actions, driven_crane.NAMES)):
            if given not in known:
                raise ValueError(f"{given!r}; allowed: {', '.join(known)}")
        self.machine = load_machine(machine) if isinstance(machine, str) else machine
        self._name, self._actions, self._mismatch = task, actions, mismatch
        entries = MACHINE + (tasks.PathTask if task == "path" else tasks.ReachTask).entries
        most = np.concatenate([np.full(one.size, one.greatest, np.float32) for one in entries])
        self.observation_space = gymnasium.spaces.Box(-most, most, dtype=np.float32)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (3,), np.float32)
        self._most = most
        self._task: Task
        self._crane: DrivenCrane
        self._steps, self._action = STEPS + 1, (0.0, 0.0, 0.0)  # no episode is under way

    def reset(
        self,
        *,
        seed: int | None = None,
        options: dict[str, Any] | None = None,  # noqa: ARG002  Gymnasium's
    ) -> tuple[Numbers, dict[str, Any]]:
        """Draw a task and a machine; return the first observation, of a step at rest, and figures."""
        super().reset(seed=seed)
        self._task = tasks.drawn(self._name, self.machine, self.np_random)
        noise, drawn = (int(n) for n in self.np_random.integers(DRAWN, size=2))
        self._crane = self._at_rest(noise, drawn)
        self._steps = 0
        observation, _, _, _, told = self.step(np.zeros(3, np.float32))
        return observation, told

    def step(self, action: Numbers) -> tuple[Numbers, float, bool, bool, dict[str, Any]]:
        """Move the crane over 20 ms; return observation, reward, False, whether time is up, and figures.

        Raises:
            ValueError: the action is not three finite numbers.
            gymnasium.error.ResetNeeded: no episode is under way.
        """
        if self._steps > STEPS:
            raise gymnasium.error.ResetNeeded("no episode is under way; allowed: reset")
        given = np.asarray(action, dtype=np.float64)
        if given.shape != (3,) or not np.isfinite(given).all():
            raise ValueError(f"action {action!r}; allowed: three finite numbers")
        x, y, z = given.clip(-1.0, 1.0).tolist()
        self._action = x, y, z
        sensed = self._crane.move(self._action)
        self._steps += 1
        time = (PERIODS * self._steps - 1) * PERIOD
        reward, figures = self._task.judged(time, sensed.tip)
        told = {**figures, "time": time, "stopped": self._crane.stopped}
        return self._observation(sensed, time), reward, False, self._steps > STEPS, told

    def _at_rest(self, noise: int, drawn: int) -> DrivenCrane:
        ranges = model_mismatch.Ranges()
        plant = (
            model_mismatch.applied(self.machine, model_mismatch.draw(drawn, ranges))
            if self._mismatch
            else None
        )
        start, suite = pose_at(self._task.start, self.machine), noisy(self.machine, noise)
        if self._actions == "voltages":
            return ValveCrane(self.machine, start, suite, plant)
        return LeverCrane(self.machine, self._actions, start, suite, STEPS + 1, plant)

    def _observation(self, sensed: Sensed, time: float) -> Numbers:
        pressures = [pressure / MEGA for pressure in sensed.pressures]
        found = [*sensed.angles, *sensed.rates, *pressures, *sensed.tip, *self._action]
        seen = np.nan_to_num(np.array(found + self._task.seen(time, sensed.tip), dtype=np.float32))
        return np.clip(seen, -self._most, self._most)


gymnasium.register("ForestCrane-v0", entry_point=CraneEnv)
