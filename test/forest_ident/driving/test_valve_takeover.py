"""Claims about who has the valves in an experiment, and that they are given back, whatever answers."""

import pytest

from forest_ident.driving.valve_takeover import CONTROLLER, DRIVER, ValveTakeover
from forest_msgs_py.introspection.live_graph import NoAnswer
from forest_msgs_py.runtime.publishers import UNKNOWN

OPERATOR = "experiment_operator"


class Graph:
    """Stands in for a running graph: who publishes, which parameters they have, and who refuses."""

    def __init__(self, *publishers, refuses=()):
        self.values = {DRIVER: {"compensate": True}, CONTROLLER: {"hands_off": False}}
        self.publishers, self.refuses, self.said, self.is_closed = list(publishers), set(refuses), [], False

    def get(self, node, names):
        return {name: self.values[node][name] for name in names}

    def set(self, node, values):
        if node in self.refuses:
            raise NoAnswer("no answer")
        self.said.append(node)
        self.values[node].update(values)

    def publishers_of(self, _topic):
        return self.publishers

    def close(self):
        self.is_closed = True


TAKEN = {DRIVER: {"compensate": False}, CONTROLLER: {"hands_off": True}}


@pytest.mark.parametrize("found", [True, False])
def test_the_valves_are_taken_and_given_back_as_they_were_found(found):
    graph = Graph(CONTROLLER)
    graph.values = {DRIVER: {"compensate": found}, CONTROLLER: {"hands_off": found}}
    takeover = ValveTakeover(graph)
    takeover.apply()
    assert graph.values == TAKEN
    assert graph.said == [CONTROLLER, DRIVER]  # it commands nothing before the driver passes volts on
    takeover.close()
    assert graph.values == {DRIVER: {"compensate": found}, CONTROLLER: {"hands_off": found}}
    assert graph.said[2:] == [DRIVER, CONTROLLER]
    assert graph.is_closed


def test_without_a_controller_only_the_driver_is_asked():
    graph = Graph()
    ValveTakeover(graph).apply()
    assert graph.said == [DRIVER]


def test_a_driver_that_refuses_leaves_the_controller_as_it_was():
    graph = Graph(CONTROLLER, refuses=[DRIVER])
    with pytest.raises(NoAnswer, match="no answer"):
        ValveTakeover(graph).apply()
    assert graph.values[CONTROLLER] == {"hands_off": False}
    assert graph.said == [CONTROLLER, CONTROLLER]


def test_what_cannot_be_put_back_is_told_and_the_rest_is_put_back():
    graph = Graph(CONTROLLER)
    takeover = ValveTakeover(graph)
    takeover.apply()
    graph.refuses = {DRIVER}
    with pytest.raises(NoAnswer) as told:
        takeover.close()
    assert str(told.value) == "valve_driver: compensate = True could not be put back (no answer)"
    assert graph.is_closed
    assert graph.values[CONTROLLER] == {"hands_off": False}
    graph.refuses = {DRIVER, CONTROLLER}
    assert takeover.restore().count("could not be put back") == 2


def test_alone_is_an_operator_beside_nodes_that_were_taken_off():
    takeover = ValveTakeover(Graph(CONTROLLER))
    assert takeover.is_alone(OPERATOR, [OPERATOR, CONTROLLER], begun=False)
    assert takeover.is_alone(OPERATOR, [OPERATOR], begun=True)


def test_a_controller_that_comes_late_is_taken_off_before_the_experiment_begins():
    graph = Graph()
    takeover = ValveTakeover(graph)
    takeover.apply()
    assert not takeover.is_alone(OPERATOR, [OPERATOR, CONTROLLER], begun=False)
    assert graph.values == TAKEN
    assert takeover.is_alone(OPERATOR, [OPERATOR, CONTROLLER], begun=False)
    takeover.close()
    assert graph.values[CONTROLLER] == {"hands_off": False}


@pytest.mark.parametrize("begun", [False, True])
def test_another_publisher_of_commands_ends_it_by_name(begun):
    takeover = ValveTakeover(Graph())
    with pytest.raises(NoAnswer, match=r"^stranger publishes valve_commands, too; stop it first$"):
        takeover.is_alone(OPERATOR, ["stranger", OPERATOR, "another", "third"], begun)


def test_a_controller_that_comes_in_mid_experiment_ends_it():
    graph = Graph()
    takeover = ValveTakeover(graph)
    with pytest.raises(NoAnswer, match="controller publishes"):
        takeover.is_alone(OPERATOR, [OPERATOR, CONTROLLER], begun=True)
    assert graph.said == []


def test_a_publisher_whose_name_is_not_known_yet_is_waited_for_until_the_experiment_runs():
    graph = Graph()
    takeover = ValveTakeover(graph)
    assert not takeover.is_alone(OPERATOR, [OPERATOR, UNKNOWN], begun=False)
    assert graph.said == []
    with pytest.raises(NoAnswer):
        takeover.is_alone(OPERATOR, [OPERATOR, UNKNOWN], begun=True)
