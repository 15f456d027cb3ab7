"""A listener on the valves, and the graph as a process."""

import math
import time

import pytest
from lockstep_sessions import LEVERS, LOCKSTEP_STEPS, lockstep_session, run_in_lockstep
from rclpy.executors import SingleThreadedExecutor

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import read_float_array
from forest_msgs_py.runtime.node import subscription
from forest_msgs_py.runtime.polled_subscription import sent_at


class Valves:
    """Hears /valve_voltages and remembers when the valves were last told to open, and last told to shut."""

    def __init__(self, node):
        self.node, self.executor = node, SingleThreadedExecutor(context=node.context)
        self.executor.add_node(node)
        self.count, self.opened, self.shut = 0, -math.inf, -math.inf
        self.ear = subscription(node, topics.VALVE_VOLTAGES, self._hear)

    def _hear(self, message, info):
        # When it was said: what a dead writer left unacknowledged may come a second late, and a machine that
        # counts age from publishing does not obey it.
        said = sent_at(info)
        reading = read_float_array(topics.VALVE_VOLTAGES, message, 0)
        assert not reading.problem
        self.count += 1
        if any(reading.values):
            self.opened = max(self.opened, said)
        else:
            self.shut = max(self.shut, said)

    @property
    def open(self):
        """Whether the last word was to open, lately."""
        return self.opened > self.shut and time.monotonic() - self.opened < 0.05


@pytest.fixture
def valves(make_node):
    # No services: a reply to a recorder that has gone is a warning, and here warnings are errors.
    listener = Valves(make_node("listener", start_parameter_services=False))
    yield listener
    listener.executor.shutdown()


@pytest.fixture
def start_graph(start_process, domain_id):
    """Start scripts/graph.sh's program; give its process."""
    return lambda *options: start_process(["-m", "forest_bringup.graph", *options])


@pytest.fixture(scope="session")
def levers(tmp_path_factory):
    """A lever file of a second."""
    path = tmp_path_factory.mktemp("levers") / "levers.csv"
    path.write_text(LEVERS)
    return path


@pytest.fixture(scope="session")
def lockstep_bag(tmp_path_factory, session_domain_id, levers):
    """A run in lockstep, on a computer that does nothing else."""
    out = tmp_path_factory.mktemp("run")
    run_in_lockstep(lockstep_session(out, levers), LOCKSTEP_STEPS, out, session_domain_id)
    return out / "bag"
