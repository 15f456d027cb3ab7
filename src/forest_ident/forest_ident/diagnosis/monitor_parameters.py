"""Parameters of the monitor's node."""

from __future__ import annotations

from typing import Annotated, NamedTuple

from forest_msgs_py.runtime.parameter_table import Parameter
from forest_msgs_py.types import PERIOD


class MonitorParameters(NamedTuple):
    """Of `monitor_node`."""

    period: Annotated[float, Parameter("nominal period of the joints", "s", 1e-4, 0.1)] = PERIOD
    timeout: Annotated[float, Parameter("age at which a sensor's topic is silent", "s", 0.01, 2.0)] = 0.1
    slow_timeout: Annotated[
        float, Parameter("age at which the driver's status is silent", "s", 0.1, 10.0)
    ] = 0.5
    report_period: Annotated[float, Parameter("period of the findings' report", "s", 0.1, 600.0)] = 1.0
