"""A lockstep run's messages come out in one order, however its nodes' batches came in."""

from hypothesis import given
from hypothesis import strategies as st

from forest_msgs_py.clock.step_order import BatchMessage, StepOrder

ROLLS = {
    "simulator": ("/joint_states J", "/clock C", "/robot_description S latched"),
    "controller": ("/valve_commands F", "/tip/pose P", "/diagnostics D"),
    "valve_driver": ("/valve_voltages F", "/diagnostics D"),
}
LAST = {"simulator": 4, "controller": 4, "valve_driver": 3}  # steps of which they tell
EXPECTED_STEP = ["/joint_states", "/valve_commands", "/valve_voltages", "/tip/pose", "/diagnostics", "/clock"]


def said(node, step):
    """All that a node says in a step: one message on each of its topics, but diagnostics in step 1 alone."""
    return [
        BatchMessage(place, step, f"{node} {output} {step}".encode())
        for place, output in enumerate(output for output in ROLLS[node] if "latched" not in output)
        if "diagnostics" not in output or step == 1
    ]


def run(rolls, halves, order_of_batches):
    """Feed announcements in an order, then everything else; return what came out, and the order."""
    order, out = StepOrder(tuple(ROLLS)), []
    for node in rolls:
        order.add_announcement("\n".join((node, *ROLLS[node])))
    feed = [("simulator", lambda: order.add_transient_local("/robot_description", b"urdf"))]
    for (node, last), half in zip(LAST.items(), halves, strict=True):
        for first, until in ((1, half), (half + 1, last)):
            messages = [one for step in range(first, until + 1) for one in said(node, step)]
            feed.append((node, lambda n=node, f=first, u=until, m=messages: order.add_batch(n, f - 1, u, m)))
    # Accounts of a node come in their order, those of several nodes in any.
    for node in order_of_batches:
        feed.pop(next(i for i, (who, _) in enumerate(feed) if who == node))[1]()
        out += order.complete()
    return out, order


BATCHES = ("simulator", *(node for node in ROLLS for _ in range(2)))
USUAL = run(ROLLS, (1, 1, 1), BATCHES)[0]


@given(st.permutations(tuple(ROLLS)), st.tuples(*[st.integers(1, 2)] * 3), st.permutations(BATCHES))
def test_order_and_number_do_not_depend_on_arrival(rolls, halves, batches):
    out, order = run(rolls, halves, batches)
    assert out == USUAL
    assert order.reached == 3


def test_a_step_is_in_the_order_of_the_announced_outputs():
    assert USUAL[0] == ("/robot_description", 0, b"urdf")
    step_1 = [message for message in USUAL if message[1] == 1]
    assert list(dict.fromkeys(name for name, _, _ in step_1)) == EXPECTED_STEP
    assert [data for name, _, data in step_1 if name == "/diagnostics"] == [
        b"controller /diagnostics D 1",
        b"valve_driver /diagnostics D 1",
    ]


def test_a_step_waits_for_the_account_of_each_node_and_names_who_is_behind():
    _, order = run(ROLLS, (1, 1, 1), BATCHES)
    assert order.missing() == "step 4: no account of valve_driver"
    order.add_batch("valve_driver", 3, 4, [])
    assert [name for name, _, _ in order.complete()] == [
        "/joint_states",
        "/valve_commands",
        "/tip/pose",
        "/clock",
    ]
    assert order.reached == 4


def test_nothing_is_complete_before_every_node_has_told_its_outputs():
    order = StepOrder(("a", "b"))
    order.add_announcement("a\n/x T")
    order.add_batch("a", 0, 1, [BatchMessage(0, 1, b"")])
    assert list(order.complete()) == []
    assert order.missing() == "step 0: no outputs told by b"
    order.add_announcement("b\n/y T")
    order.add_batch("b", 0, 1, [])
    assert [name for name, _, _ in order.complete()] == ["/x"]


def test_nothing_is_complete_before_every_latched_topic_was_said():
    order = StepOrder(("a",))
    order.add_announcement("a\n/x T\n/l S latched")
    order.add_batch("a", 0, 1, [BatchMessage(0, 1, b"")])
    assert list(order.complete()) == []
    assert order.missing() == "step 0: no message on /l"
    order.add_transient_local("/l", b"")
    assert [(name, step) for name, step, _ in order.complete()] == [("/l", 0), ("/x", 1)]


def test_a_latched_topic_of_two_nodes_is_complete_when_both_have_spoken():
    order = StepOrder(("a", "b"))
    for node in ("a", "b"):
        order.add_announcement(f"{node}\n/{node} T\n/l S latched")
        order.add_batch(node, 0, 1, [])
    order.add_transient_local("/l", b"first")
    assert list(order.complete()) == []
    assert order.missing() == "step 0: no message on /l"
    order.add_transient_local("/l", b"and second")
    assert list(order.complete()) == [("/l", 0, b"and second"), ("/l", 0, b"first")]


def test_a_latched_message_may_come_before_its_node_has_told_its_outputs():
    order = StepOrder(("a", "b"))
    order.add_announcement("a\n/l S latched")
    order.add_transient_local("/l", b"of a")
    order.add_transient_local("/l", b"of b")
    order.add_announcement("b\n/l S latched")
    assert [data for _, _, data in order.complete()] == [b"of a", b"of b"]


def test_what_is_said_on_a_latched_topic_in_the_middle_of_a_run_is_recorded_there():
    order = StepOrder(("a",))
    order.add_announcement("a\n/x T\n/l S latched")
    order.add_transient_local("/l", b"start")
    order.add_batch("a", 0, 1, [])
    assert list(order.complete()) == [("/l", 0, b"start")]
    order.add_transient_local("/l", b"stop")
    order.add_batch("a", 1, 3, [])
    assert list(order.complete()) == [("/l", 2, b"stop")]


def test_a_lost_account_is_named_and_nothing_after_it_counts():
    order = StepOrder(("a", "b"))
    for node in ("a", "b"):
        order.add_announcement(f"{node}\n/{node} T")
        order.add_batch(node, 0, 20, [BatchMessage(0, 20, b"")])
    order.add_batch("b", 20, 60, [BatchMessage(0, 60, b"")])
    order.add_batch("a", 40, 60, [BatchMessage(0, 60, b"")])
    assert [(name, step) for name, step, _ in order.complete()] == [("/a", 20), ("/b", 20)]
    assert order.reached == 20
    assert order.lost == "the account of a of steps 21 to 40 was lost"
