"""When a node in lockstep has waited too long, and the failure that it ends with; see `lockstep`."""

from collections.abc import Sequence

from forest_msgs_py.clock.step_topics import StepSubscription
from forest_msgs_py.runtime.node import NodeFailure
from forest_msgs_py.types import PERIOD_NS

LOOP = ("joystick", "controller", "valve_driver")  # as a step passes from one to the next


def extra_time(waited: StepSubscription, inputs: Sequence[StepSubscription], step: int, leads: bool) -> float:
    """How much longer than the guard a node waits [s].

    When one node hangs, all wait. Whoever has got a part of the step waits for the one that hangs, or for
    one behind it in the loop: the nearer to the loop's beginning, the sooner he speaks. Who has got
    nothing waits for all of them; the fewer things he reads, the better he knows.

    Args:
        waited: what is waited for.
        inputs: all that the node reads.
        step: of which something is missing.
        leads: whether the node begins each step.
    """
    for polled in inputs:
        polled.collect()
    if not leads and not any(polled.has(step * PERIOD_NS) for polled in inputs):
        return 2.0 + len(LOOP) + len(inputs)
    hops = [LOOP.index(who) for who in waited.topic.publishers if who in LOOP]
    return 1.0 * min(hops, default=len(LOOP))


def timeout_failure(
    waited: StepSubscription, inputs: Sequence[StepSubscription], step: int, guard: float
) -> NodeFailure:
    """Name all that is missing of a step, and who should have said it.

    Args:
        waited: what is waited for.
        inputs: all that the node reads.
        step: of which something is missing.
        guard: how long was waited [s].
    """
    for polled in inputs:
        polled.collect()
    missing = [polled for polled in inputs if not polled.has(step * PERIOD_NS)] or [waited]
    names = ", ".join(polled.name for polled in missing)
    people = ", ".join(dict.fromkeys(who for polled in missing for who in polled.topic.publishers))
    return NodeFailure(
        f"step {step}: waited {guard:g} s for {names} of {people or 'nobody known'}; "
        "see its log, or allow more with the parameter lockstep_guard"
    )
