"""What a person or a program may do to a player while it plays: keys, services, parameters, without ROS."""

from collections.abc import Callable
from typing import Any

from forest_bag.play.playback import Player
from forest_bag.play.player_parameters import HIGHEST_RATE
from forest_msgs_py.types import NS_PER_S

RATE_STEP = 1.1
SEEK_STEP_S = 5.0
KEYS = "space: pause; right: next message; left: 5 s back; up, +: faster; down, -: slower"


class RemoteControl:
    """Commands to a player, each with the sentence that answers it.

    Args:
        player: that obeys.
        span: first and last log time of the bag, ns.
        set_rate: sets the parameter, so that whoever asks for it learns what a key did.
        say: tells the user.
    """

    def __init__(
        self,
        player: Player,
        span: tuple[int, int],
        set_rate: Callable[[float], None],
        say: Callable[[str], object],
    ) -> None:
        self._player, self._span, self._set_rate, self._say = player, span, set_rate, say

    @property
    def highest(self) -> dict[str, float]:
        """Highest value of each parameter; the lowest is 0."""
        return {"rate": HIGHEST_RATE, "seek": (self._span[1] - self._span[0]) / NS_PER_S}

    @property
    def services(self) -> dict[str, Callable[[], tuple[bool, str]]]:
        """Actions by the service's name, each giving success and a sentence."""
        return {
            "pause": lambda: (True, self._pause()),
            "resume": lambda: (True, self._resume()),
            "toggle_paused": lambda: (True, self._toggle()),
            "play_next": self._next,
        }

    @property
    def keys(self) -> dict[str, Callable[[], object]]:
        """Actions by the key's name."""
        player = self._player
        return {
            "space": lambda: self._say(self._toggle()),
            "right": player.step,
            "left": lambda: player.seek(player.position_ns - round(SEEK_STEP_S * NS_PER_S)),
            **dict.fromkeys(("up", "+"), lambda: self._set_rate(min(player.rate * RATE_STEP, HIGHEST_RATE))),
            **dict.fromkeys(("down", "-"), lambda: self._set_rate(player.rate / RATE_STEP)),
        }

    def refuse(self, name: str, value: Any) -> str:
        """Say why a parameter may not have a value; "" if it may, or is none of these."""
        if name not in self.highest:
            return ""
        high = self.highest[name]
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if number and 0.0 <= value <= high:
            return ""
        return f"parameter '{name}' is {value!r}; allowed: 0 .. {high:g}"

    def apply(self, name: str, value: Any) -> None:
        """Act on a parameter that was set."""
        if name == "rate":
            self._player.set_rate(float(value))
            self._say(f"rate {float(value):.3g}")
        elif name == "seek":
            self._player.seek(self._span[0] + round(float(value) * NS_PER_S))
            self._say(f"at {float(value):.3f} s")

    def _pause(self) -> str:
        self._player.pause()
        return f"paused at {self._where()}"

    def _resume(self) -> str:
        self._player.resume()
        return f"playing from {self._where()}"

    def _toggle(self) -> str:
        return self._resume() if self._player.paused else self._pause()

    def _next(self) -> tuple[bool, str]:
        if self._player.step():
            return True, f"one message from {self._where()} on"
        return False, "not paused; allowed: play_next while paused"

    def _where(self) -> str:
        return f"{(self._player.position_ns - self._span[0]) / NS_PER_S:.3f} s"
