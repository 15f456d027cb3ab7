"""`forest-ident`, the program: the verbs of `forest_ident`, and `experiment`, which starts a graph."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from forest_ident import ident_cli
from forest_study import experiment_command
from forest_study.exclusive import Failure


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one verb; return its exit code."""
    return ident_cli.main(arguments, (experiment_command,), (Failure,))


if __name__ == "__main__":
    sys.exit(main())
