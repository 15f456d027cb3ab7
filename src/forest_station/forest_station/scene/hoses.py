"""Hoses from the valves on the platform to the actuators, fixed to links, for the eye.

Nobody told how they run. Assumed: the valves lie on the left of the platform, and the stick's
hoses follow the boom.
"""

from forest_description.types import AXES
from forest_station.scene.scene_elements import FlowSignal, Hose, HosePoint, Joint, Visual

FULL_FLOW = 2e-3  # [m^3/s] of a port at full speed, about; for the look of the dashes only
FULL_SPEED = {"swing": 150.0, "boom": 0.15, "stick": 0.15}  # [rad/s] of the motor, [m/s] of a cylinder
FULL_VOLTAGE = 10.0  # [V] of a spool
SPACING = 0.07  # [m] between two hoses side by side


def hoses_of(links: dict[str, list[Visual]], joints: list[Joint]) -> list[Hose]:
    """Return both hoses of each axis whose actuator is drawn."""
    hoses = []
    for axis in AXES:
        for port in (1, 2):
            points = _points(axis, port, links, joints)
            if points:
                hoses.append(Hose(name=f"{axis}_{port}", points=points, flow=_flow(axis, port)))
    return hoses


def _flow(axis: str, port: int) -> list[FlowSignal]:
    """Return the signals that tell the flow, best first: a meter, the actuator's speed, the spool."""
    actuator = f"{axis}_motor" if axis == "swing" else f"{axis}_cylinder"
    sign = 1.0 if port == 1 else -1.0
    told = (
        (f"hydraulics/flows/{axis}_1", FULL_FLOW),
        (f"actuator_states/{actuator}.velocity", FULL_SPEED[axis]),
        (f"hydraulics/auxiliary/{axis}_spool", FULL_VOLTAGE),
        (f"valve_voltages/{axis}", FULL_VOLTAGE),
    )
    return [FlowSignal(signal=signal, factor=sign / full) for signal, full in told]


def _points(axis: str, port: int, links: dict[str, list[Visual]], joints: list[Joint]) -> list[HosePoint]:
    side = SPACING * (AXES.index(axis) * 2 + port - 3.5)
    valve = HosePoint(link="platform", xyz=[side, 0.4, -0.1])
    if axis == "swing":
        return [valve, _point("platform", side, 0.48, -0.35), _point("platform", 0.5 * side, 0.36, -0.6)]
    barrel = f"{axis}_barrel"
    pivot = next((joint for joint in joints if joint["child"] == barrel), None)
    if pivot is None or not links.get(barrel):
        return []
    length, radius = links[barrel][0]["size"][1], links[barrel][0]["size"][0]
    along = 0.12 * length if port == 1 else 0.88 * length
    end = _point(barrel, along, 1.1 * radius, 0.0)
    if axis == "boom":
        return [
            valve,
            _point("platform", 0.35 + side, 0.45, -0.2),
            _point(barrel, along, 2.5 * radius, 0.1),
            end,
        ]
    x, _, z = pivot["xyz"]
    beam = links[pivot["parent"]][0]["size"][1]
    left, over = 0.6 * beam, 0.1 * beam + 0.5 * SPACING * (port - 1.5)
    run = [_point(pivot["parent"], share * x, left, over) for share in (0.1, 0.35, 0.7)]
    return [valve, _point("platform", 0.1, 0.35, 0.25), *run, _point(pivot["parent"], x, left, 0.4 * z), end]


def _point(link: str, x: float, y: float, z: float) -> HosePoint:
    return HosePoint(link=link, xyz=[x, y, z])
