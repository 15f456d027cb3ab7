"""The node for taught work, as the station asks it and hears of it."""

from pathlib import Path
from typing import Any

from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter

from forest_msgs_py.safety.diagnostics import WELL
from forest_station.graph.notices import STALE, PartStatus
from forest_station.graph.service_calls import NoAnswer, ServiceCalls

NODE = "cycle"
PART = "taught work"  # of the node's diagnostics
NAMES = ("phase", "cycle", "segment")  # of its values
ABSENT = "There is no node for taught work: start the graph with scripts/graph.sh --cycles DIR."
GONE: dict[str, Any] = {"there": False, "phase": "", "cycle": "", "segment": "", "text": ABSENT}


class CycleClient:
    """Asks the node `cycle`.

    Args:
        calls: services of the graph.
    """

    def __init__(self, calls: ServiceCalls) -> None:
        self._calls = calls
        self.told = GONE

    def hear(self, part: PartStatus) -> bool:
        """Take in what the node's diagnostics tell; tell whether that is news."""
        before, self.told = self.told, _told(part)
        return self.told != before

    async def folder(self) -> Path:
        """Return where the node keeps the user's cycles.

        Raises:
            NoAnswer: the node is not there.
        """
        self._must_be_there()
        request = GetParameters.Request(names=["directory"])
        answer = await self._calls.call(GetParameters, f"{NODE}/get_parameters", request)
        return Path(answer.values[0].string_value)

    async def ask(self, service: str, **names: str) -> str:
        """Call a service of the node, after its parameters were set that say what it is about.

        Raises:
            NoAnswer: the node is not there, or refuses.
        """
        self._must_be_there()
        if names:
            values = [Parameter(name, value=value).to_parameter_msg() for name, value in names.items()]
            request = SetParameters.Request(parameters=values)
            answer = await self._calls.call(SetParameters, f"{NODE}/set_parameters", request)
            if refused := [result.reason for result in answer.results if not result.successful]:
                raise NoAnswer(f"{refused[0]}.")
        return await self._calls.trigger(f"{NODE}/{service}")

    def _must_be_there(self) -> None:
        if not self.told["there"]:
            raise NoAnswer(ABSENT)


def _told(part: PartStatus) -> dict[str, Any]:
    if part.level == STALE:
        return GONE
    text = "" if part.text == WELL else f"{part.text}."
    return {"there": True, "text": text} | {name: part.values.get(name, "") for name in NAMES}
