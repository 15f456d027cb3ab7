"""The controller's parameters of a crane whose joints are all unlike, so that none is taken for another."""

from forest_control.config import controller_settings
from forest_control.valve.valve_driver_parameters import AxisDriver
from forest_description.machine import load_machine
from forest_description.types import Vec3

# Edges of the overlap [V], lags of the spools [s], rated voltages [V]: of swing, boom, stick.
FORWARD, BACKWARD = (0.5, 0.6, 0.7), (0.9, 1.0, 1.1)
LAGS, RATED = (0.01, 0.03, 0.06), (10.0, 8.0, 6.0)

P = controller_settings.parameters(load_machine("c180_hoses"), controller_settings.Settings())


def _axis(i: int) -> AxisDriver:
    axis = P.speed_limits.axes[i]
    valve = axis.valve._replace(
        forward=axis.valve.forward._replace(deadband_voltage=FORWARD[i]),
        backward=axis.valve.backward._replace(deadband_voltage=BACKWARD[i]),
    )
    return axis._replace(spool=axis.spool._replace(lag=LAGS[i]), valve=valve)


UNLIKE = P._replace(
    rated_voltages=RATED,
    rated_speeds=(2.0, 0.2, 0.1),
    speed_limits=P.speed_limits._replace(axes=(_axis(0), _axis(1), _axis(2))),
)


def at(joint: int, value: float, others: float = 0.0) -> Vec3:
    """Return one joint's value among the others'."""
    swing, boom, stick = (value if i == joint else others for i in range(3))
    return swing, boom, stick
