"""Shapes as visualization_msgs: what RViz, Foxglove and Lichtblick draw beside a robot."""

from collections.abc import Iterable
from typing import Any

from builtin_interfaces.msg import Duration
from geometry_msgs.msg import Point
from visualization_msgs.msg import Marker, MarkerArray

from forest_msgs_py.interfaces.messages import ns_to_stamp
from forest_msgs_py.types import NS_PER_S


def marker_array(stamp_ns: int, shapes: Iterable[Any]) -> MarkerArray:
    """Markers that are added, or renewed.

    Args:
        stamp_ns: ROS time [ns].
        shapes: Each with `namespace`, `number`, `kind`, `frame`, `color`, `lifetime` [s], `size`,
            `centre` and `points` [m]. Their frames move with them as long as they live.
    """
    return MarkerArray(markers=[_marker(stamp_ns, shape) for shape in shapes])


def removal(namespace: str) -> MarkerArray:
    """What takes all markers of a namespace away."""
    return MarkerArray(markers=[Marker(ns=namespace, action=Marker.DELETEALL)])


def _marker(stamp_ns: int, shape: Any) -> Marker:
    marker = Marker(ns=shape.namespace, id=shape.number, type=shape.kind, action=Marker.ADD)
    marker.header.frame_id, marker.header.stamp = shape.frame, ns_to_stamp(stamp_ns)
    sec, nanosec = divmod(round(shape.lifetime * NS_PER_S), NS_PER_S)
    marker.lifetime, marker.frame_locked = Duration(sec=sec, nanosec=nanosec), True
    marker.scale.x, marker.scale.y, marker.scale.z = map(float, shape.size)
    color, place = marker.color, marker.pose.position
    color.r, color.g, color.b, color.a = map(float, shape.color)
    place.x, place.y, place.z = map(float, shape.centre)
    marker.points = [Point(x=x, y=y, z=z) for x, y, z in shape.points]
    return marker
