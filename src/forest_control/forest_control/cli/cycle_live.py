"""`forest-control cycle record|play|pause|resume|stop`: taught work in the graph that runs.

Each asks the node `cycle` (`scripts/graph.sh --cycles DIR`), which does the work, and goes on without this
program.
"""

import argparse
from typing import Any

from forest_control.config.setting_file import SettingFileError
from forest_control.taught.cycle_file import checked_name
from forest_control.taught.player import Phase
from forest_control.taught.taught_work import TEACHES
from forest_msgs_py.interfaces import topics
from forest_msgs_py.runtime.command_line import Command, Subcommands, subcommand

NODE = "cycle"
DONE = (Phase.FINISHED, Phase.PAUSED, Phase.IDLE)
LONGEST = 3600.0  # [s] that `play --wait` waits: no cycle takes longer


def add_parsers(verbs: Subcommands) -> None:
    """Add the verbs and their flags."""
    text = "teach a cycle's next segment: a path, driven until stop, or the place where the tip is"
    record = _verb(verbs, "record", text, _record)
    record.add_argument("name", metavar="NAME", help="name of the cycle; a new name begins a new cycle")
    record.add_argument("--what", choices=TEACHES, default="path", help="kind of the segment (default: path)")
    record.add_argument("--label", default="", metavar="TEXT", help="name of the segment (default: its kind)")
    play = _verb(verbs, "play", "play a cycle from its beginning, once the deadman is held", _play)
    play.add_argument("name", metavar="NAME", help="name of the cycle")
    play.add_argument(
        "--wait", action="store_true", help="wait until the cycle is finished; exit code 1 if it is paused"
    )
    for name, text in (
        ("stop", "end what is taught, and keep it; or end what is played"),
        ("pause", "pause what is played; the tip is held"),
        ("resume", "go on after a pause, or confirm the grapple"),
    ):
        _verb(verbs, name, text, _tell).set_defaults(service=name)


def _verb(verbs: Subcommands, name: str, text: str, run: Command) -> argparse.ArgumentParser:
    parser = subcommand(verbs, name, text, run)
    parser.add_argument("--namespace", default="/", help="ROS namespace of the graph (default: /)")
    return parser


def _record(options: argparse.Namespace) -> int:
    return _ask(options, TEACHES[options.what], {"cycle": checked_name(options.name), "label": options.label})


def _play(options: argparse.Namespace) -> int:
    return _ask(options, "play", {"cycle": checked_name(options.name)}, options.wait)


def _tell(options: argparse.Namespace) -> int:
    return _ask(options, options.service, {})


def _ask(options: argparse.Namespace, service: str, names: dict[str, str], wait: bool = False) -> int:
    from forest_msgs_py.introspection.live_graph import LiveGraph, NoAnswer

    graph = LiveGraph("/" + options.namespace.strip("/"))
    try:
        if service == "play":  # what is planned keeps to the walls that the controller keeps to
            names |= graph.get("controller", ["workspace"])
        if names:
            graph.set(NODE, names)
        print(graph.trigger(NODE, service), flush=True)
        return _outcome(graph) if wait else 0
    except NoAnswer as error:
        raise SettingFileError(str(error)) from error
    finally:
        graph.close()


def _outcome(graph: Any) -> int:
    """Wait until the cycle is over, and return the exit code."""
    message = graph.wait_for_message(topics.CYCLE_STATUS, lambda said: _phase(said) in DONE, LONGEST)
    phase = Phase(_phase(message)) if message else Phase.IDLE
    print(phase.name.lower())
    return int(phase != Phase.FINISHED)


def _phase(message: Any) -> int:
    """Return the phase that a message on `cycle/status` tells."""
    return int(message.data[message.layout.data_offset])
