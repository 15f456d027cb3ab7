"""Manual control of three levers by a simulated operator, towards where the grip should be.

| mode | a lever moves | what is left is seen as |
|---|---|---|
| joint | a joint | the joints' ways to the goal's pose |
| tip, assisted | the tip to the left, outwards, up | turn about the crane, radius, height |

The operator sees the crane late, by his own delay and the link's, and reckons with a share of what is under
way (`foresight`). A deflection is k e / m of its full way: e is what is left, m the greatest speed, and

    k = 1 / (2.718 T)             with T the delay that is left,

the greatest gain with which an integrator behind a delay T does not overshoot. So whoever sees late goes
slowly. Three things make it worse:

- The map from what is left to the levers is wrong: (1 + E) in place of 1, E new for each leg, of
  `joint_error` or `tip_error`. It is right at the goal, and its way there is bent.
- Attention serves `axes` levers at once: those with the longest time left. It stays there for `dwell`.
- Deflections jitter by `precision` of themselves (signal-dependent noise: Harris and Wolpert 1998).
"""

import math
from collections import deque

import numpy as np

from forest_control.operator.levers import REST, Levers
from forest_description.types import Floats
from forest_study.log_work.person import Person

CRANE_LAG = 0.15  # [s] of valves and oil, which every operator knows of a machine; assumed
JITTER = 0.3  # [s] correlation time of a deflection's jitter: a correction takes as long; assumed
LEAST_GAIN_DELAY = 0.05  # [s] below which no delay counts
WORST = 0.6  # [1] of E: beyond, a lever might be pushed the wrong way for good
NONE = 0.02  # [1] of a deflection that does nothing, and that the hand leaves out: a lever's play


class ManualControl:
    """An operator at the levers, a look at a time.

    Args:
        person: what the operator is like.
        error: share by which the map to the levers is wrong.
        trip: the link's round trip [s].
        look: time between two looks [s].
        seed: of jitter, attention and the map's errors.
    """

    def __init__(self, person: Person, error: float, trip: float, look: float, seed: int) -> None:
        self._person, self._error, self._look = person, error, look
        self._rng = np.random.default_rng([seed, 8])
        late = person.delay + trip
        self._under_way: deque[Floats] = deque([np.zeros(3)], maxlen=max(1, round(late / look)))
        delay = late * (1.0 - person.foresight) + person.hand + CRANE_LAG
        self._gain = 1.0 / (math.e * max(LEAST_GAIN_DELAY, delay))
        self._lever, self._jitter, self._map = np.zeros(3), np.zeros(3), np.eye(3)
        self._served, self._until = np.ones(3, dtype=bool), 0.0

    def new_leg(self) -> None:
        """Aim anew: the map's errors are others, and attention is free."""
        wrong = np.clip(self._error * self._rng.standard_normal((3, 3)), -WORST, WORST)
        wrong[0, 1:] = wrong[1:, 0] = 0.0  # the swing is not mistaken for the others
        wrong -= 0.5 * np.diag(np.diag(wrong))  # how fast a joint goes is known better than what it moves
        self._map = np.eye(3) + wrong
        self._until = 0.0

    def rest(self) -> Levers:
        """Let go of the levers."""
        return self._pushed(np.zeros(3))

    def steer(self, left: Floats, speeds: Floats, time: float) -> Levers:
        """Return the levers towards a goal.

        Args:
            left: what is seen to be left, in the levers' own coordinates [3] rad or m.
            speeds: at full deflection [3] rad/s or m/s.
            time: now [s].
        """
        ahead = self._person.foresight * np.sum(self._under_way, axis=0) * self._look * speeds
        e = self._map @ ((left - ahead) / speeds)  # [s] left at full speed
        if time >= self._until:
            self._attend(np.abs(e), time)
        wanted = np.where(self._served, self._gain * e, 0.0)
        greatest = float(np.abs(wanted).max())
        if greatest > self._person.boldness:
            wanted *= self._person.boldness / greatest
        return self._pushed(_beyond_play(wanted))

    def _attend(self, left: Floats, time: float) -> None:
        """Choose the levers to be served, the longest time first."""
        whole = int(self._person.axes)
        count = whole + int(self._rng.random() < self._person.axes - whole)
        self._served = np.zeros(3, dtype=bool)
        self._served[np.argsort(-left)[:count]] = True
        self._until = time + self._person.dwell

    def _pushed(self, wanted: Floats) -> Levers:
        """Return the levers as the arm moves them."""
        keep = math.exp(-self._look / JITTER)
        self._jitter = keep * self._jitter + math.sqrt(1.0 - keep * keep) * self._rng.standard_normal(3)
        meant = wanted * (1.0 + self._person.precision * self._jitter)
        self._lever = self._lever + (1.0 - math.exp(-self._look / self._person.hand)) * (meant - self._lever)
        if not wanted.any() and np.abs(self._lever).max() < NONE:
            self._lever = np.zeros(3)
        self._under_way.append(self._lever)
        said = np.clip(self._lever, -1.0, 1.0).tolist()
        return Levers(*said) if any(said) else REST


def _beyond_play(wanted: Floats) -> Floats:
    """Return deflections without those within the lever's play; of these alone the greatest leaves it."""
    pushed = np.where(np.abs(wanted) < NONE, 0.0, wanted)
    if not pushed.any() and wanted.any():
        most = int(np.argmax(np.abs(wanted)))
        pushed[most] = math.copysign(NONE, wanted[most])
    return pushed
