"""What several property tests draw, and how they run a stateful machine."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import run_state_machine_as_test

ANY = st.floats() | st.sampled_from((math.nan, math.inf, -math.inf))


def between(low: float, high: float) -> st.SearchStrategy[float]:
    """A number within bounds: a peculiar one, or one of the many in between."""
    return st.floats(low, high) | st.integers(0, 1000).map(lambda k: low + (high - low) * k / 1000)


def vectors(low: float, high: float) -> st.SearchStrategy[tuple[float, ...]]:
    """Three numbers within bounds."""
    return st.tuples(*[between(low, high)] * 3)


def near(low: float, high: float) -> st.SearchStrategy[tuple[float, ...]]:
    """Three numbers within bounds, of which one may be any number or none."""
    three, other = vectors(low, high), st.integers(0, 2)
    return three | st.builds(lambda v, i, x: (*v[:i], x, *v[i + 1 :]), three, other, ANY)


def spoilt(good: bytes, most: int = 5) -> st.SearchStrategy[bytes]:
    """Good bytes of which some are changed, cut out, repeated or added."""
    at = st.integers(0, len(good))
    taken = st.sampled_from((None, None, 0, 1, 8, 40, len(good)))  # None: as many as are put there
    edit = st.tuples(at, taken, st.binary(max_size=8) | at.map(lambda k: good[k : k + 20]))

    def edited(edits: list[tuple[int, int | None, bytes]]) -> bytes:
        data = bytearray(good)
        for place, count, new in edits:
            data[place : place + (len(new) if count is None else count)] = new
        return bytes(data)

    return st.lists(edit, max_size=most).map(edited)


def holds(machine: Callable[..., Any], examples: int, steps: int) -> None:
    """Run a stateful machine by the suite's settings."""
    run_state_machine_as_test(machine, settings=settings(max_examples=examples, stateful_step_count=steps))
