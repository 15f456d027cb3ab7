"""Taught work as the server answers: pages of the cycles, what goes to the node, and edits of files."""

import asyncio
import json
from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from aiohttp import web
from aiohttp.test_utils import TestClient, TestServer

from forest_control.taught.cycle import Cycle, Grapple, Pose
from forest_control.taught.cycle_file import load_cycle, save_cycle
from forest_description.machine import load_machine
from forest_station.graph.cycle_client import ABSENT, CycleClient
from forest_station.graph.notices import STALE, PartStatus
from forest_station.graph.service_calls import NoAnswer
from forest_station.server.cycle_pages import REQUESTS, routes
from forest_station.server.requests import Question, answered

LOAD = Cycle("load", (Pose("out", (5.0, 0.5, 1.0), 0.3), Grapple("take", "close")))
VALUES = {"phase": "paused", "cycle": "load", "segment": "out"}


class Node:
    """The node's client: it has a folder, and notes what it is asked."""

    def __init__(self, folder):
        self.directory, self.asked = folder, []

    async def folder(self):
        if self.directory is None:
            raise NoAnswer(ABSENT)
        return self.directory

    async def ask(self, service, **names):
        self.asked.append((service, names))
        return "done."


@pytest.fixture
def station(tmp_path):
    save_cycle(LOAD, tmp_path)
    graph = SimpleNamespace(cycles=Node(tmp_path), machine=load_machine("c180_hoses"))
    cab = SimpleNamespace(seat=SimpleNamespace(driver="1"))
    return SimpleNamespace(graph=graph, cab=cab, walls=lambda: ("c180", 0.5))


def ask(station, request, page="1", **arguments):
    return asyncio.run(answered(station, page, Question(request, 1, arguments), REQUESTS))


def get(station, *paths):
    async def fetched():
        app = web.Application()
        app.router.add_routes(routes(station))
        async with TestClient(TestServer(app)) as client:
            answers = [await client.get(path) for path in paths]
            return [(answer.status, await answer.text()) for answer in answers]

    return asyncio.run(fetched())


def test_the_pages_tell_the_cycles_and_what_one_is(station):
    (_, cycles), (_, load), (status, none) = get(
        station, "/cycles.json", "/cycles/load.json", "/cycles/none.json"
    )
    assert {"name": "load", "own": True} in json.loads(cycles)
    assert {"name": "transport", "own": False} in json.loads(cycles)
    assert [segment["name"] for segment in json.loads(load)["segments"]] == ["out", "take"]
    assert (status, none[:15]) == (400, "cycle 'none': t")
    station.graph.cycles.directory = None
    assert get(station, "/cycles.json") == [(400, ABSENT)]


def test_what_is_asked_of_the_node_names_the_cycle_and_the_controllers_walls(station):
    ask(station, "play_cycle", cycle="load")
    ask(station, "teach", cycle="load", what="path", label=" round ")
    ask(station, "teach", cycle="load", what="close")
    for what in ("pause_cycle", "resume_cycle", "stop_cycle"):
        assert ask(station, what)["ok"]
    assert station.graph.cycles.asked == [
        ("play", {"cycle": "load", "workspace": "c180"}),
        ("record", {"cycle": "load", "label": "round"}),
        ("close", {"cycle": "load", "label": ""}),
        *((verb, {}) for verb in ("pause", "resume", "stop")),
    ]


def test_who_looks_on_may_pause_and_end_and_nothing_else(station):
    allowed = {what for what in REQUESTS if ask(station, what, page="2")["ok"]}
    assert allowed == {"pause_cycle", "stop_cycle"}


@pytest.mark.parametrize(
    ("what", "arguments", "sentence"),
    [
        ("play_cycle", {"cycle": "../up"}, "Cycle '../up': allowed: a name of letters"),
        ("play_cycle", {}, "Cycle '': allowed"),
        ("teach", {"cycle": "load", "what": "dance"}, "What is 'dance'; allowed: path, pose, close, open."),
        ("teach", {"cycle": "load", "what": ["pose"]}, "What is"),
        ("teach", {"cycle": "load", "what": "pose", "label": "\ud800"}, "Label is"),
        ("teach", {"cycle": "load", "what": "pose", "label": "x" * 61}, "Label is"),
        ("change_segment", {"cycle": "load", "segment": "out", "changes": 3}, "Changes are '3'"),
        ("change_segment", {"cycle": "load", "segment": "out", "changes": {"speed": 9}}, "Cycle 'load': "),
        ("move_segment", {"cycle": "load", "segment": "out", "by": "up"}, "By is 'up'"),
        ("delete_segment", {"cycle": "load", "segment": "none"}, "Cycle 'load': no segment 'none'"),
        ("delete_segment", {"cycle": "none", "segment": "out"}, "Cycle 'none': there is none"),
    ],
)
def test_what_is_not_allowed_is_refused_and_changes_nothing(station, what, arguments, sentence, tmp_path):
    told = ask(station, what, **arguments)
    assert (told["ok"], told["text"][: len(sentence)]) == (False, sentence)
    assert station.graph.cycles.asked == []
    assert load_cycle("load", tmp_path) == LOAD


def test_edits_are_kept_in_the_users_folder(station, tmp_path):
    assert ask(station, "change_segment", cycle="load", segment="out", changes={"speed": 0.4})["ok"]
    assert ask(station, "move_segment", cycle="load", segment="take", by=-1)["ok"]
    assert ask(station, "delete_segment", cycle="reach-grasp", segment="reach")["ok"]
    assert load_cycle("load", tmp_path).segments == (LOAD.segments[1], LOAD.segments[0]._replace(speed=0.4))
    assert load_cycle("reach-grasp", tmp_path).segments[0].name == "grasp"


def test_the_node_is_there_while_it_tells_of_itself():
    client = CycleClient(calls=None)
    assert client.told["text"] == ABSENT
    told = PartStatus("cycle: taught work", "warning", "load: paused: a stick moved", VALUES)
    assert [client.hear(told), client.hear(told)] == [True, False]
    assert client.told == {"there": True, "text": "load: paused: a stick moved.", **VALUES}
    assert client.hear(told._replace(level="ok", text="well"))
    assert client.told["text"] == ""
    assert client.hear(told._replace(level=STALE))
    assert not client.told["there"]
    with pytest.raises(NoAnswer, match=r"scripts/graph\.sh --cycles"):
        asyncio.run(client.ask("play"))
