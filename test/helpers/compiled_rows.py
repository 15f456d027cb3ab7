"""A session of the compiled loop, row by row, with numbers of its state that a test looks at."""

from collections.abc import Iterator
from typing import Any

from forest_compile import flat_layout
from forest_study.closed_loop import compiled_loop, loop_kernel


def states_of(prepared: compiled_loop.Prepared, *paths: str) -> Iterator[list[float]]:
    """Yield the numbers at paths of a `Loop` after each row, such as `control.state.weighing.mass`."""
    names = [path for path, _ in flat_layout.leaves(loop_kernel.example()[1], "loop")]
    places = [names.index(f"loop.{path}") for path in paths]
    session = compiled_loop.Session(prepared)
    for row in range(len(prepared.levers)):
        session.advance(row + 1)
        found: Any = session.state[places].tolist()
        yield found
