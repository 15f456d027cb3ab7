"""Which valves the driver cannot learn, and why: it takes a position, pressures and a drop that it knows.

| reason | what is missing |
|---|---|
| open at the centre | an overlap |
| no sensor of its actuator's position, no pressure sensors | the flow, its drop |
"""

from forest_control.valve.valve_adaptation import underlapped
from forest_description.machine import Machine
from forest_description.types import AXES


def unlearnt_valves(machine: Machine) -> dict[str, str]:
    """Return why `adapt` has no effect, by axis; axes whose valves are learnt are left out.

    Args:
        machine: as the driver believes it.
    """
    reasons = ((name, _reason(machine, axis)) for axis, name in enumerate(AXES))
    return {name: reason for name, reason in reasons if reason}


def told(machine: Machine) -> str:
    """Return in one line which valves are not learnt, and why; "" if all are."""
    return "; ".join(f"{name}: {reason}" for name, reason in unlearnt_valves(machine).items())


def _reason(machine: Machine, axis: int) -> str:
    if underlapped(machine.valve_of(axis).law):
        return "open at the centre, it has no overlap"
    if machine.sensors.pressure is None:
        return "no pressure sensors"
    sensor = machine.sensors.resolver if axis == 0 else machine.sensors.linear_transducer
    return "" if sensor is not None else "no sensor of its actuator's position"
