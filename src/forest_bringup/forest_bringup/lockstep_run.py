"""A run in lockstep: nodes that wait for each other, for a number of steps, into a bag."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from forest_bringup import graph
from forest_bringup.supervisor import NodeSpec, Supervisor

GUARD = 20.0  # [s]
RECORDER, PLAYER = "recorder", "step_player"


def in_lockstep(nodes: Sequence[NodeSpec], steps: int, guard: float = GUARD) -> list[NodeSpec]:
    """Return the same nodes, waiting for each other in every one of so many steps.

    Args:
        nodes: one that leads (the simulator, the bag feeder) and those who follow it, perhaps a recorder.
        steps: of the run.
        guard: how long a node waits for a message [s, wall clock].
    """
    guarded = graph.parameter("lockstep_guard", guard)
    stepping: tuple[str, ...] = (*guarded, *graph.parameter("lockstep", True))
    if any(node.name == PLAYER for node in nodes):  # it may wait for what no node reads
        stepping = (*stepping, *graph.parameter("lockstep_quiet", 1))
    recorded = any(node.name == RECORDER for node in nodes)
    leading = (*graph.parameter("steps", steps), *graph.parameter("wait_for_recorder", recorded))
    run = graph.parameter("lockstep_nodes", [node.name for node in nodes if node.name != RECORDER])
    more = dict.fromkeys(graph.LEADERS, (*stepping, *leading)) | {RECORDER: (*guarded, *run)}
    return [  # not urgent, for they wait; all needed: a run without its record would wait for ever
        node._replace(arguments=(*node.arguments, *more.get(node.name, stepping)), urgent=False, needed=True)
        for node in nodes
    ]


def run(
    nodes: Sequence[NodeSpec], steps: int, logs: Path, guard: float = GUARD, namespace: str = "/"
) -> Supervisor:
    """Run nodes, one of them a recorder, until the last of so many steps is in the bag.

    Raises:
        GraphError: a node ended unasked, or did not answer; the text names it.
        Stopped: the user asked to stop.
    """
    with Supervisor(in_lockstep(nodes, steps, guard), namespace, logs) as running:
        running.run(until=RECORDER)
    return running
