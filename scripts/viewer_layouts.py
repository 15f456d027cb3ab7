"""Writes the layouts of forest_viewers from the table of topics; a test compares.

Run `python scripts/viewer_layouts.py` after a change of a topic. Made are layouts for Foxglove and
Lichtblick (one file for both), for PlotJuggler and for RViz, and QoS overrides for `ros2 bag`. Arrays have
places where people want names: every value is shown under its label.
"""

import json
from collections.abc import Iterator
from colorsys import hsv_to_rgb
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import yaml

from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import STAMP_SIZE
from forest_msgs_py.interfaces.topic_qos import offered_qos
from forest_msgs_py.interfaces.topics import FLOAT_ARRAY, JOINT_STATE, JOY_TYPE, POSE, TOPICS, TWIST, Topic

FOLDER = Path(__file__).resolve().parents[1] / "src/forest_viewers/forest_viewers/layouts"
NUMBERS = (FLOAT_ARRAY, JOINT_STATE, JOY_TYPE, POSE, TWIST)
SHOWN = tuple(topic for topic in TOPICS if topic.recorded and topic.type in NUMBERS)
FIELDS = {
    topics.VIEWER_JOINT_STATES: 1,
    topics.GROUND_TRUTH_HEAD: 2,
}  # of position, velocity, effort; others: 3
QOS_KEYS = ("history", "depth", "reliability", "durability")
MINUTE = 60.0  # [s] that plots show
BASE = "base_link"


class Value(NamedTuple):
    """One number of a topic: where it is in the message, what it is called, its unit."""

    path: str  # within the message, as in Foxglove's message paths
    label: str
    unit: str


def values(topic: Topic) -> Iterator[Value]:
    """Give the numbers of a topic in the order of its labels."""
    named = list(zip(topic.labels, topic.units, strict=True))
    if topic.type == FLOAT_ARRAY:
        yield from (Value(f"data[{n + STAMP_SIZE}]", *told) for n, told in enumerate(named))
    elif topic.type == JOINT_STATE:
        for k, field in enumerate(("position", "velocity", "effort")[: FIELDS.get(topic, 3)]):
            for n, (joint, units) in enumerate(named):
                yield Value(f"{field}[{n}]", f"{joint} {field}", units.split(", ")[k])
    elif topic.type == JOY_TYPE:
        yield from (Value(f"axes[{n}]", *told) for n, told in enumerate(named))
        yield from (Value(f"buttons[{n}]", label, "1") for n, label in enumerate(topics.JOY_BUTTONS))
    else:
        for label, unit in named:
            part = f"pose.orientation.{label[1:]}" if label.startswith("q") else f"pose.position.{label}"
            yield Value(f"twist.linear.{label}" if topic.type == TWIST else part, label, unit)


def by_unit(topic: Topic) -> dict[str, list[Value]]:
    """Return a topic's numbers, those of one unit together: they share a plot."""
    found: dict[str, list[Value]] = {}
    for value in values(topic):
        found.setdefault(value.unit, []).append(value)
    return found


def resolved(topic: Topic) -> str:
    """Return a topic's name in the root namespace."""
    return f"/{topic.name.lstrip('/')}"


def foxglove() -> str:
    """Return the layout of Foxglove and Lichtblick."""
    panels: dict[str, Any] = {"3D!crane": _scene(), "DiagnosticSummary!all": {}, "RosOut!log": {}}
    panels |= {"Parameters!all": {}, "SourceInfo!topics": {}}
    tabs = []
    for topic in SHOWN:
        plots = {
            f"Plot!{topic.name} {unit}": _plot(topic, unit, told) for unit, told in by_unit(topic).items()
        }
        panels |= plots
        tabs.append({"title": topic.name, "layout": _stacked(list(plots))})
    panels["Tab!topics"] = {"activeTabIdx": SHOWN.index(topics.PRESSURES), "tabs": tabs}
    about = [
        {"title": "diagnostics", "layout": "DiagnosticSummary!all"},
        {"title": "log", "layout": "RosOut!log"},
        {"title": "parameters", "layout": "Parameters!all"},
        {"title": "topics", "layout": "SourceInfo!topics"},
    ]
    panels["Tab!about"] = {"activeTabIdx": 0, "tabs": about}
    left = {"direction": "column", "first": "3D!crane", "second": "Tab!about", "splitPercentage": 70}
    whole = {"direction": "row", "first": left, "second": "Tab!topics", "splitPercentage": 55}
    parts = {"configById": panels, "globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1}}
    return json.dumps(parts | {"layout": whole}, indent=1, ensure_ascii=False) + "\n"


def _scene() -> dict[str, Any]:
    """Return the 3D panel: the crane by its description and frames, and the markers."""
    urdf = {
        "layerId": "foxglove.Urdf", "instanceId": "crane", "label": "crane", "visible": True, "order": 2,
        "sourceType": "topic", "topic": resolved(topics.ROBOT_DESCRIPTION), "displayMode": "visual",
        "framePrefix": "", "fallbackColor": "#d8903c",
    }  # fmt: skip
    grid = {
        "layerId": "foxglove.Grid", "instanceId": "grid", "label": "ground", "visible": True, "order": 1,
        "frameId": BASE, "size": 20, "divisions": 20, "lineWidth": 1, "color": "#80808066",
        "position": [0, 0, -2.2], "rotation": [0, 0, 0],
    }  # fmt: skip
    camera = {
        "perspective": True, "distance": 16, "phi": 65, "thetaOffset": 60, "fovy": 45, "near": 0.5,
        "far": 500, "target": [0, 0, 0], "targetOffset": [2, 0, 0], "targetOrientation": [0, 0, 0, 1],
    }  # fmt: skip
    return {
        "followTf": BASE, "followMode": "follow-none", "cameraState": camera,
        "scene": {"transforms": {"showLabel": False, "axisScale": 0}},
        "topics": {resolved(topics.VIEWER_MARKERS): {"visible": True}},
        "layers": {"grid": grid, "crane": urdf}, "transforms": {}, "publish": {}, "imageMode": {},
    }  # fmt: skip


def _plot(topic: Topic, unit: str, told: list[Value]) -> dict[str, Any]:
    stamped = "receiveTime" if topic.type == FLOAT_ARRAY else "headerStamp"
    paths = [
        {
            "value": f"{resolved(topic)}.{one.path}",
            "label": one.label,
            "enabled": True,
            "timestampMethod": stamped,
        }
        for one in told
    ]
    return {
        "foxglovePanelTitle": f"{topic.name} [{unit}]", "paths": paths, "showLegend": True,
        "legendDisplay": "left", "showPlotValuesInLegend": True, "showXAxisLabels": True,
        "showYAxisLabels": True, "isSynced": True, "xAxisVal": "timestamp", "sidebarDimension": 200,
        "followingViewWidth": MINUTE,
    }  # fmt: skip


def _stacked(names: list[str]) -> Any:
    """Return panels one above the other, all of one height."""
    if len(names) == 1:
        return names[0]
    share = 100.0 / len(names)
    return {"direction": "column", "first": names[0], "second": _stacked(names[1:]), "splitPercentage": share}


def plotjuggler() -> str:
    """Return the layout of PlotJuggler: a tab for each topic, a plot for each unit."""
    root = ElementTree.Element("root")
    window = ElementTree.SubElement(root, "tabbed_widget", parent="main_window", name="Main Window")
    named = ElementTree.Element("customMathEquations")
    for topic in SHOWN:
        plots = by_unit(topic)
        tab = ElementTree.SubElement(window, "Tab", tab_name=topic.name, containers="1")
        sizes = ";".join(f"{1.0 / len(plots):.6f}" for _ in plots)
        splitter = ElementTree.SubElement(
            ElementTree.SubElement(tab, "Container"),
            "DockSplitter",
            orientation="|",
            sizes=sizes,
            count=f"{len(plots)}",
        )
        for unit, told in plots.items():
            area = ElementTree.SubElement(splitter, "DockArea", name=f"{topic.name} [{unit}]")
            plot = ElementTree.SubElement(area, "plot", style="Lines", mode="TimeSeries")
            for number, one in enumerate(told):
                curve = _curve(topic, one, named)
                ElementTree.SubElement(plot, "curve", name=curve, color=_colour(number, len(told)))
    ElementTree.SubElement(window, "currentTabIndex", index=str(SHOWN.index(topics.PRESSURES)))
    ElementTree.SubElement(root, "use_relative_time_offset", enabled="1")
    root.append(named)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode", xml_declaration=True) + "\n"


def _colour(number: int, count: int) -> str:
    """Return the colour of one of a plot's curves: without one PlotJuggler draws all in black."""
    red, green, blue = hsv_to_rgb(number / count, 0.85, 0.85 if number % 2 else 0.65)
    return "#" + "".join(f"{round(255 * part):02x}" for part in (red, green, blue))


def _curve(topic: Topic, value: Value, named: ElementTree.Element) -> str:
    """Return the name of a series; of an array's value it is a series of its own, added to `named`."""
    if topic.type == JOINT_STATE:  # PlotJuggler knows its joints by name
        joint, field = value.label.split(" ")
        return f"{resolved(topic)}/{joint}/{field}"
    series = f"{resolved(topic)}/{value.path.replace('.', '/')}"
    if not series.endswith("]"):
        return series
    name = f"{topic.name}/{value.label}"
    snippet = ElementTree.SubElement(named, "snippet", name=name)
    ElementTree.SubElement(snippet, "global")
    ElementTree.SubElement(snippet, "function").text = "return value"
    ElementTree.SubElement(snippet, "linked_source").text = series
    return name


def qos_overrides() -> str:
    """Return what `ros2 bag record` and `play` take as --qos-profile-overrides-path."""
    told = {}
    for topic in TOPICS:
        if topic.recorded:
            offered = {key: offered_qos(topic)[key] for key in QOS_KEYS}
            told[resolved(topic)] = offered | ({"reliability": "best_effort"} if topic.sensed else {})
    return yaml.safe_dump(told, sort_keys=False)


def rviz() -> str:
    """Return the configuration of RViz: crane, frames, markers, ground."""
    latched = {"Depth": 1, "Durability Policy": "Transient Local", "Reliability Policy": "Reliable"}
    described = latched | {"Value": resolved(topics.ROBOT_DESCRIPTION)}
    ground = {"Plane Cell Count": 20, "Cell Size": 1, "Offset": {"X": 0, "Y": 0, "Z": -2.2}}
    shown = [
        _display("Grid", "ground", **ground),
        _display("RobotModel", "crane", **{"Description Source": "Topic", "Description Topic": described}),
        _display("MarkerArray", "markers", Topic={"Value": resolved(topics.VIEWER_MARKERS)}),
        _display("TF", "frames", **{"Show Names": False, "Marker Scale": 0.5}) | {"Enabled": False},
    ]  # fmt: skip
    view = {
        "Class": "rviz_default_plugins/Orbit",
        "Distance": 16,
        "Pitch": 0.4,
        "Yaw": 1.0,
        "Name": "Current View",
    }
    manager = {
        "Displays": shown,
        "Global Options": {"Fixed Frame": BASE, "Frame Rate": 30, "Background Color": "48; 48; 48"},
        "Tools": [
            {"Class": f"rviz_default_plugins/{name}"} for name in ("MoveCamera", "Measure", "FocusCamera")
        ],
        "Views": {"Current": view},
    }
    panels = [{"Class": f"rviz_common/{name}", "Name": name} for name in ("Displays", "Views", "Time")]
    return yaml.safe_dump({"Panels": panels, "Visualization Manager": manager}, sort_keys=False)


def _display(kind: str, name: str, **settings: Any) -> dict[str, Any]:
    return {"Class": f"rviz_default_plugins/{kind}", "Name": name, "Enabled": True, **settings}


MADE = {
    "foxglove.json": foxglove,
    "plotjuggler.xml": plotjuggler,
    "qos_overrides.yaml": qos_overrides,
    "crane.rviz": rviz,
}


def main() -> None:
    """Write every layout."""
    FOLDER.mkdir(exist_ok=True)
    for name, make in MADE.items():
        (FOLDER / name).write_text(make(), encoding="utf-8")


if __name__ == "__main__":
    main()
