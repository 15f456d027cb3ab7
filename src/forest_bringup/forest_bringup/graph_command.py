"""A command that runs a graph until Ctrl-C, and tells at the terminal how it went."""

import sys
import tempfile
from collections.abc import Callable, Sequence
from operator import methodcaller
from pathlib import Path
from typing import Any

from forest_bringup.graph_lock import GraphError
from forest_bringup.supervisor import NodeSpec, Stopped, Supervisor


def run_command(
    program: str,
    nodes: Sequence[NodeSpec],
    namespace: str,
    run: Callable[[Supervisor], None] = methodcaller("run"),
    only: Sequence[str] = (),
    may_publish: bool = True,
    **options: Any,
) -> int:
    """Run nodes; return 0 after a stop on request, 1 after a failure, which is told in one sentence.

    Args:
        program: name of the command.
        nodes: in the order in which they are to be stopped.
        namespace: of the graph.
        run: what the running graph is to do.
        only: names of those nodes that are started here, while another host starts the others; none: all.
        may_publish: the supervisor may publish zero voltage; it does so where it starts the valve driver.
        options: further ones of `Supervisor`.
    """
    try:
        here = part_of(nodes, only)
    except GraphError as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 2
    # A part without the driver has its zero from the driver, which hears of no command any more.
    may_publish = may_publish and (not only or "valve_driver" in only)
    logs = Path(tempfile.mkdtemp(prefix=f"forest-{program}-"))
    print(f"starting {', '.join(node.name for node in here)}; logs in {logs}; Ctrl-C stops", flush=True)
    try:
        with Supervisor(here, namespace, logs, may_publish=may_publish, **options) as graph:
            run(graph)
    except Stopped:
        print("stopped", flush=True)
    except (GraphError, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 1
    return int(any(graph.exit_codes.values()))


def part_of(nodes: Sequence[NodeSpec], only: Sequence[str]) -> list[NodeSpec]:
    """Return the nodes of some names, or all where none is named.

    Raises:
        GraphError: a name is no node's.
    """
    names = [node.name for node in nodes]
    if strange := [name for name in only if name not in names]:
        raise GraphError(f"--only {strange[0]!r} is no node of this graph; allowed: {', '.join(names)}")
    return [node for node in nodes if not only or node.name in only]
