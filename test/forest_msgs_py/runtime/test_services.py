"""An action of a node: what becomes of a goal, with a client's handle that is stood for by its states."""

from types import SimpleNamespace

import pytest

pytest.importorskip("rclpy")

from forest_msgs_py.runtime.services import Goal, offer_action

KIND = SimpleNamespace(Feedback=SimpleNamespace, Result=SimpleNamespace)


class Handle:
    """What rclpy gives for a goal; it is executed at once."""

    def __init__(self, cancelled=False):
        self.request, self.is_cancel_requested = "a request", cancelled
        self.states, self.results, self.feedback = [], [], []
        self.publish_feedback = self.feedback.append

    def execute(self, answer):
        self.results.append(answer(self))

    def succeed(self):
        self.states.append("succeeded")

    def abort(self):
        self.states.append("aborted")

    def canceled(self):
        self.states.append("canceled")


@pytest.mark.parametrize(
    ("success", "cancelled", "state"),
    [
        (True, False, "succeeded"),
        (True, True, "succeeded"),  # it was faster than the client
        (False, False, "aborted"),
        (False, True, "canceled"),
    ],
)
def test_a_goal_ends_as_its_node_and_its_client_say(success, cancelled, state):
    handle = Handle(cancelled)
    Goal(KIND, handle).end(success, error_code=3)
    assert handle.states == [state]
    assert handle.results == [SimpleNamespace(error_code=3)]


def test_a_goal_s_feedback_is_what_was_filled_in():
    handle = Handle()
    goal = Goal(KIND, handle)
    goal.tell(lambda feedback: setattr(feedback, "way", 2.0))
    assert handle.feedback == [SimpleNamespace(way=2.0)]
    assert goal.request == "a request"


def test_an_action_of_a_package_that_is_not_installed_is_not_offered():
    assert offer_action(None, "no_such_package", "Kind", "name", None) is False
