"""The shipped layouts are those of the table of topics, and each place in an array has its value's name."""

import json
import re
import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy")

from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.definitions import message_definition
from forest_msgs_py.interfaces.messages import JoyValues
from forest_msgs_py.interfaces.topics import columns
from forest_msgs_py.serialization.packing import Packer, pack_joy

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import viewer_layouts

LAYOUTS = ROOT / "src" / "forest_viewers" / "forest_viewers" / "layouts"
TABLE = {f"/{topic.name.lstrip('/')}": topic for topic in topics.TOPICS}


@pytest.fixture(scope="module")
def plotted():
    """Every series of the plots: its path and its label."""
    panels = json.loads((LAYOUTS / "foxglove.json").read_text("utf-8"))["configById"]
    plots = (panel["paths"] for name, panel in panels.items() if name.startswith("Plot!"))
    return [(path["value"], path["label"]) for paths in plots for path in paths]


def numbered(topic):
    """Return a message of different numbers, as a foreign reader sees it, and the numbers by name."""
    if topic.type == topics.JOY_TYPE:
        axes, buttons = len(topics.JOY_AXES), len(topics.JOY_BUTTONS)
        levers = JoyValues(tuple(k / 64 for k in range(axes)), tuple(range(100, 100 + buttons)))
        data = pack_joy(0, "", levers)
        named = dict(
            zip((*topics.JOY_AXES, *topics.JOY_BUTTONS), (*levers.axes, *levers.buttons), strict=True)
        )
    else:
        names, numbers = columns(topic), np.arange(1.0, 1.0 + len(columns(topic))).tolist()
        data = Packer(topic, "base_link").pack(0, numbers)
        named = {name.replace(".", " "): number for name, number in zip(names, numbers, strict=True)}
    schema = Schema(1, message_definition(topic.type).encode(), "ros2msg", topic.type)
    return DecoderFactory().decoder_for("cdr", schema)(data), named


def followed(message, path):
    """Return what a message path leads to."""
    for name, place in re.findall(r"(\w+)(?:\[(\d+)\])?", path):
        message = getattr(message, name)
        message = message[int(place)] if place else message
    return message


@pytest.mark.parametrize("name", viewer_layouts.MADE)
def test_a_layout_is_what_the_table_makes(name):
    made = viewer_layouts.MADE[name]()
    assert (LAYOUTS / name).read_text("utf-8") == made, "run: python scripts/viewer_layouts.py"


@pytest.mark.parametrize("topic", viewer_layouts.SHOWN, ids=lambda topic: topic.name)
def test_each_series_shows_the_value_that_its_label_names(plotted, topic):
    message, named = numbered(topic)
    name = f"/{topic.name.lstrip('/')}."
    shown = {label: followed(message, path[len(name) :]) for path, label in plotted if path.startswith(name)}
    assert set(topic.labels) <= {label.split(" ")[0] for label in shown}
    assert shown == {label: named[label] for label in shown}


def test_every_number_of_the_table_is_in_the_layouts_of_foxglove_and_plotjuggler(plotted):
    root = ElementTree.parse(LAYOUTS / "plotjuggler.xml").getroot()
    curves = [curve.attrib["name"] for curve in root.iter("curve")]
    named = {snippet.attrib["name"]: snippet.findtext("linked_source") for snippet in root.iter("snippet")}
    assert len(curves) == len(set(curves)) == len(plotted)
    assert named.keys() <= set(curves)
    paths = {path.replace(".", "/"): label for path, label in plotted}
    for name, source in named.items():
        assert name == f"{source.rpartition('/')[0][1:]}/{paths[source]}"
    assert not [curve for curve in curves if curve.endswith("]")]


def test_plotjuggler_draws_each_curve_of_a_plot_in_a_colour_of_its_own():
    root = ElementTree.parse(LAYOUTS / "plotjuggler.xml").getroot()
    for plot in root.iter("plot"):
        colours = [curve.get("color", "black") for curve in plot.iter("curve")]
        assert len(set(colours)) == len(colours)


def test_qos_overrides_name_every_recorded_topic_and_hear_best_effort_sensors():
    told = yaml.safe_load((LAYOUTS / "qos_overrides.yaml").read_text("utf-8"))
    assert told.keys() == {name for name, topic in TABLE.items() if topic.recorded}
    assert told["/joint_states"]["reliability"] == "best_effort"
    assert told["/robot_description"] == {
        "history": "keep_last",
        "depth": 1,
        "reliability": "reliable",
        "durability": "transient_local",
    }


def test_every_topic_that_a_layout_names_is_in_the_table():
    texts = [(LAYOUTS / name).read_text("utf-8") for name in ("foxglove.json", "crane.rviz")]
    named = {name for text in texts for name in re.findall(r'(?:topic"?|Value"?): "?(/[\w/]+)', text)}
    assert named == {"/robot_description", "/viewer/markers"}
    assert named <= TABLE.keys()
