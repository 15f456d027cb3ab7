"""Valves whose two ways differ in rating and in both edges: what confuses the ways is noticed."""

from forest_control.valve.valve_driver_parameters import AxisDriver, Parameters


def unlike(axis: AxisDriver) -> AxisDriver:
    """Return an axis whose valve has other edges and another rating backwards, and unlike edges forwards."""
    ahead, back = axis.valve.forward, axis.valve.backward
    ahead = ahead._replace(resistance_2=1.4 * ahead.resistance_2)
    back = back._replace(
        rated_voltage=0.8 * back.rated_voltage,
        resistance_1=0.7 * back.resistance_1,
        resistance_2=1.3 * back.resistance_2,
    )
    return axis._replace(valve=axis.valve._replace(forward=ahead, backward=back))


def with_unlike_ways(p: Parameters) -> Parameters:
    """Return a driver's parameters with such valves."""
    swing, boom, stick = p.axes
    return p._replace(axes=(unlike(swing), unlike(boom), unlike(stick)))
