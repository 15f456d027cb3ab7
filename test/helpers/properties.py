"""Property tests as this suite runs hypothesis, and what several of them draw.

Each run draws the same: examples come from the property's own text, and no constant of whatever modules
happen to be loaded is mixed in.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import hypothesis.configuration
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.internal.conjecture import providers
from hypothesis.stateful import run_state_machine_as_test

ROOT = Path(__file__).resolve().parents[2]
hypothesis.configuration.set_hypothesis_home_dir(ROOT / ".pytest_cache" / "hypothesis")
assert callable(providers._get_local_constants)
providers._get_local_constants = lambda: providers._local_constants

ALL = settings.get_profile("default").phases
settings.register_profile(
    "suite",
    phases=[phase for phase in ALL if phase.name not in os.environ.get("WITHOUT_PHASES", "")],
    derandomize=True,
    deadline=None,
    database=None,
    max_examples=60,
    # Fixtures hold nothing that an example changes; the first example compiles and imports.
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
settings.load_profile("suite")

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
