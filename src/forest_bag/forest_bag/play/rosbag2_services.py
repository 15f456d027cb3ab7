"""The player's services as rosbag2 has them, by the types of its package `rosbag2_interfaces`.

The package is not imported here: requests and responses are whatever has its fields.
"""

from collections.abc import Callable
from typing import Any

from forest_bag.play.playback import Player
from forest_bag.play.player_parameters import HIGHEST_RATE
from forest_msgs_py.types import NS_PER_S

Answer = Callable[[Any, Any], Any]  # from a request, and a response to be filled in, to that response


def rosbag2_services(
    player: Player, span: tuple[int, int], set_rate: Callable[[float], None]
) -> dict[str, tuple[str, Answer]]:
    """Return each service's type and what answers it, by its name.

    Args:
        player: that obeys.
        span: first and last log time of the bag, ns.
        set_rate: sets the parameter, so that whoever asks for it learns of it.
    """

    def toggle() -> None:
        (player.resume if player.paused else player.pause)()

    def set_a_rate(request: Any) -> bool:
        allowed = 0.0 < request.rate <= HIGHEST_RATE
        if allowed:
            set_rate(request.rate)
        return bool(allowed)

    def seek(request: Any) -> bool:
        time_ns = request.time.sec * NS_PER_S + request.time.nanosec
        if span[0] <= time_ns <= span[1]:
            player.seek(time_ns)
        return bool(span[0] <= time_ns <= span[1])

    return {
        "pause": ("Pause", _answer("", lambda _: player.pause())),
        "resume": ("Resume", _answer("", lambda _: player.resume())),
        "toggle_paused": ("TogglePaused", _answer("", lambda _: toggle())),
        "is_paused": ("IsPaused", _answer("paused", lambda _: player.paused)),
        "get_rate": ("GetRate", _answer("rate", lambda _: player.rate)),
        "set_rate": ("SetRate", _answer("success", set_a_rate)),
        "play": ("Play", _answer("success", lambda _: False)),  # a playback runs as long as the node does
        "play_next": ("PlayNext", _answer("success", lambda _: player.step())),
        "burst": ("Burst", _answer("actually_burst", lambda request: player.burst(request.num_messages))),
        "seek": ("Seek", _answer("success", seek)),
        "stop": ("Stop", _answer("", lambda _: player.stop())),
    }


def _answer(field: str, act: Callable[[Any], Any]) -> Answer:
    """Return what acts on a request and puts what comes of it into the response's field, if it has one."""

    def answer(request: Any, response: Any) -> Any:
        value = act(request)
        if field:
            setattr(response, field, value)
        return response

    return answer
