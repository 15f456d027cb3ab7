"""What every node computes at its start and keeps: the fork server does it once, and its nodes inherit it."""

import contextlib
import inspect

import diagnostic_msgs.msg  # noqa: F401  nodes import it when they first report
import rcl_interfaces.srv as parameter_services
import std_srvs.srv  # noqa: F401
from rclpy.type_support import check_for_type_support
from type_description_interfaces.srv import GetTypeDescription

from forest_bringup import graph_monitor  # noqa: F401  a supervisor imports it while its nodes load
from forest_control import compiled as control
from forest_description.machine import load_machine
from forest_msgs_py.interfaces import topics
from forest_msgs_py.serialization.cdr import cdr_type
from forest_sim import compiled as sim

inspect.getmodule(
    inspect.currentframe()
)  # the files of all modules: rclpy seeks them for a first line of log
control.controller_step()
control.driver_step()
sim.PLANT.ready()
sim.SENSORS.ready()
for machine in ("c180", "c180_hoses", "c180_thesis"):
    load_machine(machine)
for kind in {topic.type for topic in topics.TOPICS}:
    cdr_type(kind)
for topic in topics.TOPICS:
    with contextlib.suppress(ImportError):  # a topic's messages may not be installed
        check_for_type_support(topics.message_class(topic))
for service in (*(vars(parameter_services).values()), GetTypeDescription):
    if isinstance(service, type):
        check_for_type_support(service)
