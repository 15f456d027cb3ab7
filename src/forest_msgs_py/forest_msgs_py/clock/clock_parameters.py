"""Parameters that decide what a node's clock is: the time of day, or steps in lockstep."""

from typing import Annotated, NamedTuple

from forest_msgs_py.clock.step_topics import LATE
from forest_msgs_py.runtime.parameter_table import Parameter


class ClockParameters(NamedTuple):
    """Of every node that acts in a step."""

    lockstep: Annotated[bool, Parameter("every node waits for the messages of each step")] = False
    lockstep_guard: Annotated[float, Parameter("longest wait for a message of a step", "s", 0.1, 3600.0)] = (
        20.0
    )
    lockstep_quiet: Annotated[
        int,
        Parameter(
            "in lockstep, steps whose messages that no node waits for go out together", "steps", 1, LATE // 2
        ),
    ] = 20


class LeaderParameters(NamedTuple):
    """Of the node that begins each step, as the machine does."""

    steps: Annotated[int, Parameter("steps of the run in lockstep; 0: no end", low=0)] = 0
    wait_for_recorder: Annotated[bool, Parameter("in lockstep, wait for a recorder that falls behind")] = (
        False
    )


class ListenerParameters(NamedTuple):
    """Of the node that hears a run."""

    lockstep_nodes: Annotated[tuple[str, ...], Parameter("nodes of the run in lockstep")] = ("",)
    lockstep_guard: Annotated[float, Parameter("longest wait for a step", "s", 0.1, 3600.0)] = 20.0
