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
    **options: Any,
) -> int:
    """Run nodes; return 0 after a stop on request, 1 after a failure, which is told in one sentence.

    Args:
        program: name of the command.
        nodes: in the order in which they are to be stopped.
        namespace: of the graph.
        run: what the running graph is to do.
        options: further ones of `Supervisor`.
    """
    logs = Path(tempfile.mkdtemp(prefix=f"forest-{program}-"))
    print(f"starting {', '.join(node.name for node in nodes)}; logs in {logs}; Ctrl-C stops", flush=True)
    try:
        with Supervisor(nodes, namespace, logs, **options) as graph:
            run(graph)
    except Stopped:
        print("stopped", flush=True)
    except (GraphError, OSError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 1
    return int(any(graph.exit_codes.values()))
