"""Parameters of the on-line identification's node."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from forest_msgs_py.runtime.parameter_table import Parameter
from forest_msgs_py.types import PERIOD


class OnlineParameters(NamedTuple):
    """Of `online_identification_node`."""

    memory: Annotated[float, Parameter("age at which a sample counts 1/e", "s", 1.0, 86400.0)] = 60.0
    period: Annotated[float, Parameter("nominal period of the joints", "s", 1e-4, 0.1)] = PERIOD
    timeout: Annotated[float, Parameter("age at which pressures and voltages are lost", "s", 0.01, 2.0)] = 0.1
    report_period: Annotated[float, Parameter("period of the reports", "s", 0.1, 600.0)] = 1.0
