"""Parameters of the scripted operator's node."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from forest_description.machine import Machine
from forest_ident.experiments import experiment_plan
from forest_msgs_py.runtime.parameter_table import Parameter, ParameterError


class OperatorParameters(NamedTuple):
    """Of `experiment_operator_node`."""

    experiment: Annotated[
        str, Parameter("name of the experiment, as `forest-ident experiment list` prints")
    ] = "validation"
    seed: Annotated[int, Parameter("seed of the drawn levels", low=0)] = 0
    longest: Annotated[
        float, Parameter("end the experiment after this time, for a trial; 0: never", "s", 0.0, 1e6)
    ] = 0.0
    timeout: Annotated[float, Parameter("age at which the state is lost", "s", 0.01, 1.0)] = 0.1
    listeners: Annotated[int, Parameter("subscribers of the commands to wait for", low=0, high=9)] = 1


def planned(machine: Machine, p: OperatorParameters) -> experiment_plan.Plan:
    """Return the plan of the experiment that the parameters name.

    Raises:
        ParameterError: there is no such experiment.
    """
    allowed = [known for known in experiment_plan.names(machine) if known != "calibration"]
    if p.experiment not in allowed:
        raise ParameterError(f"parameter 'experiment' is {p.experiment!r}; allowed: {', '.join(allowed)}")
    return experiment_plan.plan(p.experiment, machine, p.seed, p.longest or math.inf)
