"""The executor of every node: it calls what rclpy's own calls, whenever nodes get or lose it."""

import threading

import pytest

pytest.importorskip("rclpy")

from rclpy.executors import ExternalShutdownException
from rclpy.task import Future
from std_msgs.msg import Float64, Float64MultiArray
from std_srvs.srv import Trigger

from forest_msgs_py.runtime.node import timer
from forest_msgs_py.runtime.static_executor import StaticExecutor


@pytest.fixture
def node(make_node):
    return make_node("waiting")


@pytest.fixture
def executor(node):
    made = StaticExecutor(context=node.context)
    made.add_node(node)
    yield made
    made.shutdown()


def test_timers_and_messages_are_called_until_they_end(node, executor, wait_until):
    heard, ticks = [], []
    ear = node.create_subscription(Float64, "numbers", lambda message: heard.append(message.data), 10)
    sender = node.create_publisher(Float64, "numbers", 10)

    def tick():
        ticks.append(1)
        sender.publish(Float64(data=float(len(ticks))))

    clock = timer(node, 0.01, tick)
    wait_until(lambda: len(heard) >= 3, executor=executor)
    assert heard == sorted(heard)
    node.destroy_timer(clock)
    node.destroy_subscription(ear)
    executor.spin_once(timeout_sec=0.02)  # takes note
    before = len(ticks), len(heard)
    sender.publish(Float64(data=0.0))
    for _ in range(5):
        executor.spin_once(timeout_sec=0.02)
    assert (len(ticks), len(heard)) == before


def test_bytes_come_with_what_the_middleware_knows_of_them(node, executor, wait_until):
    heard = []
    node.create_subscription(
        Float64MultiArray, "arrays", lambda data, info: heard.append((data, info)), 10, raw=True
    )
    sender = node.create_publisher(Float64MultiArray, "arrays", 10)
    wait_until(lambda: sender.get_subscription_count() == 1)
    sender.publish(Float64MultiArray(data=[1.0]))
    wait_until(lambda: heard, executor=executor)
    assert isinstance(heard[0][0], bytes)
    assert heard[0][1]["source_timestamp"] > 0


def test_what_a_callback_makes_is_called_and_what_it_destroys_is_not(node, executor, wait_until):
    said = []
    timer(node, 0.01, lambda: said.append("old"))

    def first():
        for one in list(node.timers):
            node.destroy_timer(one)
        timer(node, 0.01, lambda: said.append("new"))

    timer(node, 0.005, first)
    wait_until(lambda: said.count("new") >= 3, executor=executor)
    assert set(said[said.index("new") :]) == {"new"}


def test_what_another_thread_destroys_meanwhile_ends_nothing(node, executor, wait_until, monkeypatch):
    said = []
    timer(node, 0.01, lambda: said.append(1))
    gone = timer(node, 0.01, lambda: None)
    listed = list(node.timers)
    node.destroy_timer(gone)
    with monkeypatch.context() as stale:
        stale.setattr(type(node), "timers", property(lambda _: iter(listed)))  # as read before it went
        executor.spin_once(timeout_sec=0.0)
    wait_until(lambda: said, executor=executor)


def test_services_are_served_and_answers_reach_whoever_waits(node, executor, wait_until):
    node.create_service(Trigger, "ask", lambda _, answer: setattr(answer, "message", "here") or answer)
    client = node.create_client(Trigger, "ask")
    wait_until(client.service_is_ready, executor=executor)
    told = []
    client.call_async(Trigger.Request()).add_done_callback(
        lambda future: told.append(future.result().message)
    )
    wait_until(lambda: told, executor=executor)
    assert told == ["here"]


def test_a_service_is_served_though_messages_never_end(node, executor, wait_until):
    timer(node, 0.0, lambda: None)  # always ready
    node.create_service(Trigger, "ask", lambda _, answer: answer)
    client = node.create_client(Trigger, "ask")
    wait_until(client.service_is_ready, executor=executor)
    asked = client.call_async(Trigger.Request())
    wait_until(asked.done, executor=executor)


def test_a_guard_condition_wakes_it_from_another_thread(node, executor, wait_until):
    called = []
    guard = node.create_guard_condition(lambda: called.append(1))
    executor.spin_once(timeout_sec=0.0)
    later = threading.Timer(0.05, guard.trigger)
    later.start()
    wait_until(lambda: called, executor=executor)
    later.join()
    assert called == [1]


def test_tasks_and_coroutines_of_rclpy_are_run(node, executor, wait_until):
    waited = Future(executor=executor)

    async def work():
        return await waited

    task = executor.create_task(work)
    executor.spin_once(timeout_sec=0.0)
    assert not task.done()
    waited.set_result(7)
    wait_until(task.done, executor=executor)
    assert task.result() == 7


def test_what_a_callback_raises_is_raised_to_whoever_spins(node, executor, wait_until):
    def fail():
        raise RuntimeError("broken")

    timer(node, 0.001, fail)
    with pytest.raises(RuntimeError, match="broken"):
        wait_until(lambda: False, executor=executor)
    guard = node.create_guard_condition(fail)
    guard.trigger()
    with pytest.raises(RuntimeError, match="broken"):
        wait_until(lambda: False, executor=executor)


def test_a_callback_may_be_a_coroutine_that_waits(node, executor, wait_until):
    waited, told = Future(executor=executor), []

    async def slow():
        told.append("begun")
        told.append(await waited)

    node.create_subscription(Float64, "numbers", lambda _: None, 10)
    executor.spin_once(timeout_sec=0.0)
    node.create_timer(0.02, slow)
    wait_until(lambda: told, executor=executor)
    waited.set_result("ended")
    wait_until(lambda: "ended" in told, executor=executor)


def test_it_ends_with_its_context(node, executor):
    node.context.try_shutdown()
    with pytest.raises(ExternalShutdownException):
        executor.spin_once(timeout_sec=1.0)


def test_a_message_whose_callback_group_forbids_it_waits_and_wakes_nobody(node, executor, wait_until):
    from forest_msgs_py.interfaces.messages import float_array
    from forest_msgs_py.interfaces.topics import VALVE_VOLTAGES
    from forest_msgs_py.runtime.node import publisher
    from forest_msgs_py.runtime.polled_subscription import polled_subscription

    box, sender = polled_subscription(node, VALVE_VOLTAGES), publisher(node, VALVE_VOLTAGES)
    wait_until(lambda: sender.get_subscription_count() == 1)
    sender.publish(float_array(VALVE_VOLTAGES, 0, (1.0, 0.0, 0.0)))
    for _ in range(5):
        executor.spin_once(timeout_sec=0.02)
    found = []
    wait_until(lambda: found.append(box.newest()) or found[-1] is not None)
