"""`forest-ident`, the program: the verbs of `forest_ident`, and `experiment`, which starts a graph."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from forest_bringup.graph_lock import GraphError
from forest_ident.cli import verbs
from forest_study.experiments import experiment_command


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; return its exit code."""
    return verbs.main(arguments, (experiment_command,), (GraphError,))


if __name__ == "__main__":
    sys.exit(main())
