"""Parameters of the Foxglove server's node."""

from typing import Annotated, NamedTuple

from forest_msgs_py.runtime.parameter_table import Parameter


class ServerParameters(NamedTuple):
    """Of `foxglove_node`."""

    port: Annotated[
        int, Parameter("TCP port on the loopback address; 0: a free one, named in the log", "", 0, 65535)
    ] = 8765
    read_only: Annotated[bool, Parameter("clients may only read: no parameters, services or publishing")] = (
        False
    )
