"""A graph seen from outside answers even where a question is lost on the way."""

import threading

import pytest

pytest.importorskip("rclpy")

from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParameters

from forest_msgs_py.introspection import live_graph
from forest_msgs_py.introspection.live_graph import LiveGraph, NoAnswer


@pytest.fixture
def deaf(make_node):
    """Starts a node that does not hear the first questions; gives what it heard of the others."""
    over, threads = threading.Event(), []

    def start(lost):
        service = make_node("driver", start_parameter_services=False).create_service(
            SetParameters, "driver/set_parameters", lambda _, response: response
        )
        heard = []

        def answer():
            taken = 0
            while not over.wait(0.005):
                with service.handle:
                    request, header = service.handle.service_take_request(SetParameters.Request)
                if header is None:
                    continue
                taken += 1
                if taken > lost:
                    heard.append(request)
                    service.send_response(
                        SetParameters.Response(results=[SetParametersResult(successful=True)]), header
                    )

        threads.append(threading.Thread(target=answer))
        threads[-1].start()
        return heard

    yield start
    over.set()
    for thread in threads:
        thread.join()


@pytest.fixture
def graph(domain_id, monkeypatch):
    """A graph that is asked every tenth of a second."""
    monkeypatch.setattr(live_graph, "AGAIN", 0.1)
    asker = LiveGraph("/")
    yield asker
    asker.close()


def test_a_question_that_is_lost_is_put_again(deaf, graph):
    heard = deaf(lost=2)
    graph.set("driver", {"compensate": True})
    assert [(one.name, one.value.bool_value) for one in heard[0].parameters] == [("compensate", True)]


def test_who_never_answers_is_named(deaf, graph, monkeypatch):
    deaf(lost=1000)
    assert graph.wait_for("driver")
    monkeypatch.setattr(live_graph, "LOOK", 0.5)
    with pytest.raises(NoAnswer, match=r"driver did not answer within 0.5 s"):
        graph.set("driver", {"compensate": True})
