"""Parameters of the nodes that play a bag."""

from typing import Annotated, NamedTuple

from forest_msgs_py.runtime.parameter_table import Parameter, table_rows, tunable

HIGHEST_RATE = 1e6  # [1] seconds of the bag per second; chosen: no computer comes near it


class PlayerParameters(NamedTuple):
    """Of the node of `forest-bag play`, which acts on them when they are set."""

    rate: Annotated[
        float, tunable("seconds of the bag per second; 0: as fast as possible", low=0.0, high=HIGHEST_RATE)
    ] = 1.0
    seek: Annotated[float, tunable("time since the bag's start to go to", "s", 0.0)] = 0.0


DESCRIPTIONS = {row.name: row.description for row in table_rows(PlayerParameters)}


class StepPlayerParameters(NamedTuple):
    """Of `step_player_node`."""

    bag: Annotated[str, Parameter("bag that was recorded in lockstep")] = ""
    answers: Annotated[
        tuple[str, ...], Parameter("topics, without slash, that the nodes under test publish")
    ] = ("",)
