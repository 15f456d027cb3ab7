"""`forest-ident`, the program: the verbs of `forest_ident`, and `experiment`, which starts a graph."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

# Before numpy is imported. A fit's products are small: threads of BLAS wait for each other, up to seconds
# where other programs want the cores.
os.environ.setdefault("OMP_NUM_THREADS", "1")

from forest_bringup.graph_lock import GraphError
from forest_ident.cli import verbs
from forest_study.experiments import experiment_command


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; return its exit code."""
    return verbs.main(arguments, (experiment_command,), (GraphError,))


if __name__ == "__main__":
    sys.exit(main())
