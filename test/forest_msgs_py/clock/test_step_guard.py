"""Who speaks first when a node in lockstep hangs, and what it names."""

from types import SimpleNamespace
from typing import get_type_hints

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.clock import clock_parameters
from forest_msgs_py.clock.step_guard import extra_time, timeout_failure

STEP = 3


def heard(name, publishers, *steps):
    """A subscription that has the messages of some steps."""
    stamps = {step * 5_000_000 for step in steps}
    return SimpleNamespace(
        name=name,
        topic=SimpleNamespace(publishers=publishers),
        collect=lambda: None,
        has=lambda stamp: stamp in stamps,
    )


@pytest.mark.parametrize(
    ("publishers", "seconds"),
    [
        (("joystick",), 0.0),
        (("controller",), 1.0),
        (("valve_driver", "controller"), 1.0),
        (("valve_driver",), 2.0),
        (("simulator",), 3.0),
    ],
)
def test_whoever_waits_for_the_beginning_of_the_loop_speaks_first(publishers, seconds):
    waited, other = heard("/waited", publishers), heard("/other", ("simulator",), STEP)
    assert extra_time(waited, [waited, other], STEP, leads=False) == seconds
    assert extra_time(waited, [waited], STEP, leads=True) == seconds


def test_who_has_got_nothing_waits_for_all_others_and_longer_the_more_it_reads():
    early = heard("/waited", ("joystick",), STEP - 1)
    assert extra_time(early, [early], STEP, leads=False) == 6.0
    assert extra_time(early, [early, early], STEP, leads=False) == 7.0


def test_what_has_come_meanwhile_counts():
    waited, came = heard("/waited", ("controller",)), []
    waited.collect, waited.has = lambda: came.append("it"), lambda _stamp: bool(came)
    assert extra_time(waited, [waited], STEP, leads=False) == 1.0


def test_all_that_is_missing_is_named_with_those_who_owe_it_each_once():
    a, b, c = heard("/a", ("x", "y")), heard("/b", ("y",), STEP - 1), heard("/c", ("z",), STEP)
    text = str(timeout_failure(a, [a, b, c], STEP, 0.25))
    assert text.startswith("step 3: waited 0.25 s for /a, /b of x, y; ")
    assert "step 3: waited 2 s for /c of nobody known" in str(
        timeout_failure(heard("/c", ()), [c], STEP, 2.0)
    )


def bounds(kind, name):
    (row,) = get_type_hints(kind, include_extras=True)[name].__metadata__
    return kind._field_defaults[name], row.low, row.high


def test_parameters_are_bounded():
    p = clock_parameters
    assert bounds(p.ClockParameters, "lockstep_guard") == (20.0, 0.1, 3600.0)
    assert bounds(p.ListenerParameters, "lockstep_guard") == (20.0, 0.1, 3600.0)
    assert bounds(p.ClockParameters, "lockstep_quiet") == (20, 1, 20)  # half of what is known late
    assert bounds(p.LeaderParameters, "steps")[:2] == (0, 0)
    assert not p.ClockParameters().lockstep
    assert not p.LeaderParameters().wait_for_recorder
