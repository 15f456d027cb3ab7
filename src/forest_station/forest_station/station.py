"""`scripts/station.sh`: a graph with the operator's page, or the page of a graph that is running."""

import argparse
import os
import sys
import webbrowser
from collections.abc import Sequence
from pathlib import Path

from forest_bringup.graph import (
    add_graph_options,
    add_part_option,
    control,
    machine_arguments,
    parameters,
    simulator,
    taught_work,
)
from forest_bringup.graph_command import run_command
from forest_bringup.profile_choice import profile_for
from forest_bringup.supervisor import NodeSpec

ADDRESS = "the page is at "  # begins the line in which the station says where


def parse_options(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the station."""
    parser = argparse.ArgumentParser(
        prog="scripts/station.sh",
        description="Run the live graph with the operator's page until Ctrl-C.",
    )
    add_graph_options(parser)
    add_part_option(parser)
    parser.add_argument("--join", action="store_true", help="open the page of a graph that is running")
    parser.add_argument(
        "--host", default="127.0.0.1", help="address to listen on; beyond loopback with a token over TLS"
    )
    parser.add_argument("--port", type=int, default=8080, help="port to listen on (default: %(default)s)")
    parser.add_argument(
        "--bags", type=Path, default=Path("bags"), metavar="DIR", help="directory of the bags"
    )
    parser.add_argument(
        "--cycles", type=Path, default=Path("cycles"), metavar="DIR", help="directory of taught cycles"
    )
    parser.add_argument(
        "--certificate", type=Path, metavar="FILE", help="TLS certificate; default: one is made"
    )
    parser.add_argument("--key", type=Path, metavar="FILE", help="private key of the certificate")
    parser.add_argument("--no-browser", action="store_true", help="print the page's address only")
    return parser.parse_args(arguments)


def station_nodes(options: argparse.Namespace) -> list[NodeSpec]:
    """Return the nodes to start, in the order in which they are to be stopped."""
    station = NodeSpec("station", "forest_station.station_node", _arguments(options), urgent=True)
    if options.join:
        return [station]
    profile = profile_for(None, options.profile)
    return [
        station,
        taught_work(options.machine, options.cycles),
        *control(options.machine, options.scheme, shadow=False, describe=False, profile=profile),
        simulator(options.machine),
    ]


def _arguments(options: argparse.Namespace) -> tuple[str, ...]:
    files = {"certificate": options.certificate, "key": options.key}
    values = {"host": options.host, "port": options.port, "bags": str(options.bags.resolve())}
    values |= {name: str(path.resolve()) for name, path in files.items() if path is not None}
    return *machine_arguments(options.machine), *parameters(values)


def show_line(line: str, opens: bool) -> None:
    """Print a line of a node's, and open the page whose address it tells."""
    print(line, flush=True)
    if (
        opens
        and line.startswith(ADDRESS)
        and (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    ):
        webbrowser.open(line.removeprefix(ADDRESS))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the station; return 0 after a stop on request, 1 after a failure."""
    options = parse_options(arguments)
    return run_command(
        "station",
        station_nodes(options),
        options.namespace,
        only=options.only,
        may_publish=not options.join,
        on_log_line=lambda line: show_line(line, not options.no_browser),
        exclusive=not options.join,
    )


if __name__ == "__main__":
    sys.exit(main())
