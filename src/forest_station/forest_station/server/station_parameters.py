"""Parameters of the station's node."""

from typing import Annotated, NamedTuple

from forest_control.operator.levers import BUTTON_COUNT, LEFT_SHOULDER
from forest_msgs_py.runtime.parameter_table import Parameter


class StationParameters(NamedTuple):
    """Of `station_node`."""

    host: Annotated[str, Parameter("address to listen on; beyond loopback with a token over TLS")] = (
        "127.0.0.1"
    )
    port: Annotated[int, Parameter("port to listen on", low=1, high=65535)] = 8080
    bags: Annotated[str, Parameter("directory of the bags")] = "bags"
    certificate: Annotated[str, Parameter("file of a TLS certificate; empty: a certificate is made")] = ""
    key: Annotated[str, Parameter("file of the certificate's private key")] = ""
    deadman_button: Annotated[
        int, Parameter("button of joy to hold as the deadman", low=0, high=BUTTON_COUNT - 1)
    ] = LEFT_SHOULDER
