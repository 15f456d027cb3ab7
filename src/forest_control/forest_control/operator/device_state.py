"""The state of an input device, from the events that the kernel tells.

The kernel tells changes, in reports that end with SYN_REPORT; a report counts as a whole. When it
had to drop some (SYN_DROPPED), the rest of that report is void and the state must be read anew. A
key's repetition comes from the kernel's own timer: it shows no life of the device.
"""

from collections.abc import Collection, Iterable, Mapping
from typing import NamedTuple, Protocol

from evdev import ecodes

REPEATED = 2  # [1] value of a key event that the kernel's timer made


class Event(Protocol):
    """An event as python-evdev gives it."""

    type: int
    code: int
    value: int


class DeviceState(NamedTuple):
    """Raw values of a device's axes by code, the keys that are down, and what is remembered of a report."""

    axes: Mapping[int, int]
    keys: frozenset[int]
    reports: int = 0  # that have come
    waiting: tuple[Event, ...] = ()  # events whose report has not ended
    dropping: bool = False  # the kernel dropped events of this report
    stale: bool = False  # and the state must be read anew


def after_events(state: DeviceState, events: Iterable[Event]) -> DeviceState:
    """Return a device's state after events, oldest first."""
    for event in events:
        state = _after(state, event)
    return state


def read_anew(state: DeviceState, axes: Mapping[int, int], keys: Collection[int]) -> DeviceState:
    """Return the state that the kernel holds, in place of one that is stale."""
    return state._replace(axes=axes, keys=frozenset(keys), stale=False)


def _after(state: DeviceState, event: Event) -> DeviceState:
    if event.type == ecodes.EV_SYN and event.code == ecodes.SYN_DROPPED:
        return state._replace(waiting=(), dropping=True)
    if event.type == ecodes.EV_SYN and event.code == ecodes.SYN_REPORT:
        return _reported(state)
    if state.dropping or (event.type == ecodes.EV_KEY and event.value == REPEATED):
        return state
    return state._replace(waiting=(*state.waiting, event))


def _reported(state: DeviceState) -> DeviceState:
    if state.dropping:
        return state._replace(dropping=False, stale=True, reports=state.reports + 1)
    if not state.waiting:
        return state
    axes, keys = dict(state.axes), set(state.keys)
    for event in state.waiting:
        if event.type == ecodes.EV_ABS:
            axes[event.code] = event.value
        elif event.type == ecodes.EV_KEY:
            (keys.add if event.value else keys.discard)(event.code)
    return state._replace(axes=axes, keys=frozenset(keys), reports=state.reports + 1, waiting=())
