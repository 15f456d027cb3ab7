"""A lockstep run's messages come out in one order, however they came in."""

import numpy as np

from forest_msgs_py.step_order import StepOrder

STEP = 5
ROLLS = {
    "simulator": "/joint_states J\n/clock C\n/robot_description S latched",
    "controller": "/valve_commands F\n/tip/pose P\n/diagnostics D",
    "valve_driver": "/valve_voltages F\n/diagnostics D",
}
MESSAGES = [
    (name, step * STEP, f"{name}{step}".encode())
    for step in range(1, 5)
    for name in ("/joint_states", "/clock", "/valve_commands", "/tip/pose", "/valve_voltages")
] + [("/diagnostics", step * STEP, who) for step in (1, 2) for who in (b"controller", b"driver")]
EXPECTED_STEP = ["/joint_states", "/valve_commands", "/valve_voltages", "/tip/pose", "/diagnostics", "/clock"]


def run(seed):
    """Feed everything in random order; return what came out, and the order."""
    order, out = StepOrder(tuple(ROLLS), STEP), []
    feed = [lambda n=n, r=r: order.answer_the_roll(f"{n}\n{r}") for n, r in ROLLS.items()]
    feed += [lambda m=m: order.add(*m) for m in MESSAGES]
    feed += [lambda: order.add("/robot_description", 0, b"urdf")]
    feed += [
        lambda s=s: order.silence(["/diagnostics"], s * STEP) for s in (3, 3, 4)
    ]  # one is missing in step 4
    for place in np.random.default_rng(seed).permutation(len(feed)):
        feed[place]()
        out += order.complete()
    return out, order


def test_order_and_number_do_not_depend_on_arrival():
    first, order = run(0)
    assert [run(seed)[0] for seed in range(1, 6)] == [first] * 5
    assert first[0] == ("/robot_description", 0, b"urdf")
    step_1 = [message for message in first if message[1] == STEP]
    assert list(dict.fromkeys(name for name, _, _ in step_1)) == EXPECTED_STEP
    assert [data for name, _, data in step_1 if name == "/diagnostics"] == [b"controller", b"driver"]
    assert order.reached == 3 * STEP


def test_a_step_waits_for_each_of_two_speakers_and_names_what_is_missing():
    _, order = run(0)
    assert order.missing() == "step 4: no message on /diagnostics"
    order.silence(["/diagnostics"], 4 * STEP)
    assert len(list(order.complete())) == 5
    assert order.reached == 4 * STEP


def test_nothing_is_complete_before_every_node_has_told_its_outputs():
    order = StepOrder(("a", "b"), STEP)
    order.answer_the_roll("a\n/x T")
    order.add("/x", STEP, b"")
    assert list(order.complete()) == []
    assert order.missing() == "step 0: no outputs told by b"
    order.answer_the_roll("b\n/y T")
    order.silence(["/y"], STEP)
    assert [name for name, _, _ in order.complete()] == ["/x"]
