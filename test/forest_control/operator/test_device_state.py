"""Claims about what counts of an input device's events."""

import pytest
from evdev import InputEvent, ecodes
from input_events import DROPPED, SYN

from forest_control.operator.device_state import DeviceState, after_events, read_anew

START = DeviceState({ecodes.ABS_X: 128}, frozenset())
MOVED = (ecodes.EV_ABS, ecodes.ABS_X, 200)
PRESSED = (ecodes.EV_KEY, ecodes.BTN_TL, 1)
RELEASED = (ecodes.EV_KEY, ecodes.BTN_TL, 0)


def after(*events, state=START):
    return after_events(state, [InputEvent(0, 0, *event) for event in events])


def test_a_report_counts_as_a_whole_and_when_it_has_ended():
    half = after(MOVED, PRESSED)
    assert (half.axes, half.keys, half.reports) == (START.axes, frozenset(), 0)
    whole = after(SYN, state=half)
    assert whole == DeviceState({ecodes.ABS_X: 200}, frozenset({ecodes.BTN_TL}), 1)
    assert after(RELEASED, SYN, state=whole).keys == frozenset()


def test_when_the_kernel_dropped_events_the_state_is_read_anew_and_nothing_older_counts():
    dropped = after(PRESSED, DROPPED, MOVED, SYN)
    assert (dropped.axes, dropped.keys, dropped.stale) == (START.axes, frozenset(), True)
    later = after(RELEASED, SYN, state=dropped)
    assert later.stale
    anew = read_anew(later, {ecodes.ABS_X: 7}, [ecodes.BTN_TL])
    assert (anew.axes, anew.keys, anew.stale, anew.reports) == ({ecodes.ABS_X: 7}, {ecodes.BTN_TL}, False, 2)
    assert after(MOVED, SYN, state=anew).axes == {ecodes.ABS_X: 200}


@pytest.mark.parametrize(("value", "reports"), [(1, 1), (0, 1), (2, 0)])
def test_the_kernels_own_repetition_of_a_key_is_no_sign_of_life(value, reports):
    assert (
        after((ecodes.EV_KEY, ecodes.BTN_TL, value), (ecodes.EV_SYN, ecodes.SYN_REPORT, 1)).reports == reports
    )
