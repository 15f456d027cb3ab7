"""An executor whose wait set stands: what a node waits for is collected again only when it changes.

rclpy's own executor collects everything, makes a wait set of it and wraps a callback in a task at every
wake-up, and every callback wakes it once more: half the processor time of a node that steps at 200 Hz. This
one calls at once what subscriptions and timers have ready. Guard conditions, services, clients, events and
tasks are rare, and left to rclpy. In rclcpp, `StaticSingleThreadedExecutor` is the like.
"""

from collections.abc import Iterable
from contextlib import ExitStack
from itertools import chain
from typing import Any, NamedTuple

from rclpy.context import Context
from rclpy.exceptions import InvalidHandle
from rclpy.executors import (
    ExternalShutdownException,
    ShutdownException,
    SingleThreadedExecutor,
    TimeoutException,
)
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.utilities import timeout_sec_to_nsec
from rclpy.waitable import NumberOfEntities


class StaticExecutor(SingleThreadedExecutor):  # type: ignore[misc]  # rclpy has no types
    """Runs the callbacks of its nodes in the thread that spins it."""

    def __init__(self, *, context: Context | None = None) -> None:
        super().__init__(context=context)
        self._collected: _Collection | None = None

    def spin_once(self, timeout_sec: float | None = None) -> None:
        """Wait until something is ready, and call all of it.

        Args:
            timeout_sec: for which to wait at most [s]; None: for ever.
        """
        if not self.context.ok():
            raise ExternalShutdownException
        if self._tasks:
            self._call_all()
            return
        try:
            if self._collected is None:
                self._collected = _Collection(self.get_nodes(), (self._guard, self._sigint_gc), self.context)
            ready = self._collected.wait(timeout_sec_to_nsec(timeout_sec))
        except InvalidHandle:  # something has been destroyed, here or in another thread
            self._forget()
            return
        if ready.rare:
            self._call_all()
            return
        for timer in ready.timers:
            if _is_due(timer):
                self._call(self._take_timer(timer))
        for subscription in ready.subscriptions:
            self._call(self._take_subscription(subscription))

    def _call(self, taken: Any) -> None:
        """Call what rclpy has taken for a callback; None: nothing was there."""
        if taken is None:
            return
        called = taken()
        try:
            called.send(None)
        except StopIteration:
            return
        self.create_task(called)  # a coroutine that waits for something: rclpy goes on with it

    def _call_all(self) -> None:
        """Have rclpy call whatever is ready; nodes may have got, or lost, what they wait for."""
        self._forget()
        try:
            for task, _, _ in self._wait_for_ready_callbacks(timeout_sec=0):
                task()
                task.result()  # raises what the callback has raised
        except (TimeoutException, ShutdownException):
            return

    def _forget(self) -> None:
        if self._collected is not None:
            self._collected.close()
            self._collected = None

    def shutdown(self, timeout_sec: float | None = None) -> bool:
        """End, after at most `timeout_sec` [s] (None: for ever); tell whether all callbacks have ended."""
        self._forget()
        done: bool = super().shutdown(timeout_sec)
        return done


class _Ready(NamedTuple):
    """What a wait has found."""

    timers: list[Any]
    subscriptions: list[Any]
    rare: bool  # whether there is something for rclpy


class _Collection:
    """What some nodes wait for, kept from being destroyed, and the wait set of it."""

    def __init__(self, nodes: list[Node], guards: tuple[Any, ...], context: Context) -> None:
        by_kind: dict[str, list[Any]] = {
            "subscription": _able(one for node in nodes for one in node.subscriptions),
            "guard_condition": [*_able(one for node in nodes for one in node.guards), *guards],
            "timer": _able(one for node in nodes for one in node.timers),
            "client": _able(one for node in nodes for one in node.clients),
            "service": _able(one for node in nodes for one in node.services),
        }
        self._waitables = _able(one for node in nodes for one in node.waitables)
        count = sum(
            (one.get_num_entities() for one in self._waitables),
            start=NumberOfEntities(*map(len, by_kind.values())),
        )
        with ExitStack() as kept:
            for one in (*chain.from_iterable(by_kind.values()), context):
                kept.enter_context(one.handle)
            for one in self._waitables:
                kept.enter_context(one)
            self._kept = kept.pop_all()
        self._wait_set = rclpy_implementation.WaitSet(
            *(getattr(count, name) for name in NumberOfEntities.__slots__), context.handle
        )
        self._add = [
            (getattr(self._wait_set, f"add_{kind}"), one.handle)
            for kind, some in by_kind.items()
            for one in some
        ]
        self._entities = {one.handle.pointer: one for some in by_kind.values() for one in some}

    def wait(self, timeout: int) -> _Ready:
        """Wait for at most so long [ns; negative: for ever]."""
        self._wait_set.clear_entities()
        for add, handle in self._add:
            add(handle)
        for waitable in self._waitables:
            waitable.add_to_wait_set(self._wait_set)
        self._wait_set.wait(timeout)
        return _Ready(self._ready("timer"), self._ready("subscription"), self._is_rare_ready())

    def _ready(self, kind: str) -> list[Any]:
        return [self._entities[pointer] for pointer in self._wait_set.get_ready_entities(kind)]

    def _is_rare_ready(self) -> bool:
        guards = self._ready("guard_condition")
        for guard in guards:
            guard._executor_triggered = True  # for rclpy: the wait has taken the trigger away
        others = any(self._wait_set.get_ready_entities(kind) for kind in ("client", "service"))
        return bool(guards) or others or any(one.is_ready(self._wait_set) for one in self._waitables)

    def close(self) -> None:
        """Let go of the entities; what a node has destroyed meanwhile, ends now."""
        self._kept.close()


def _is_due(timer: Any) -> bool:
    """Tell whether a timer is still due: a callback before it may have ended it."""
    try:
        due: bool = timer.handle.is_timer_ready()
    except InvalidHandle:
        return False
    return due


def _able(entities: Iterable[Any]) -> list[Any]:
    """Return those whose callback group lets them be called."""
    return [one for one in entities if one.callback_group.can_execute(one)]
