"""Where the nodes of the drawn circuits stand, in pixels; `drawing_geometry` tells how they are read.

All circuits run from left to right: supply, valve edge, hose 1, actuator, hose 2, valve edge, with
the tank below; the actuator's mechanical side stands on a panel in the middle.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

from forest_sim.linear_graph.actuation_graphs import (
    cylinder,
    cylinder_with_joint,
    cylinder_with_pi_hoses,
    cylinder_with_relief,
    cylinder_with_two_lumps,
    swing,
)
from forest_sim.linear_graph.drawing_geometry import Box, Coupling, Layout, Point, Rail
from forest_sim.linear_graph.linear_graph import Domain, LinearGraph

TOP = 80.0
BOTTOM = 350.0


class Circuit(NamedTuple):
    """A circuit that docs/explanation/linear-graphs.md tells of."""

    file: str
    title: str
    graph: Callable[[], LinearGraph]
    layout: Layout


SWING = Layout(
    width=1240,
    height=420,
    nodes={
        "supply": Point(60, TOP),
        "valve_1": Point(180, TOP),
        "hose_1": Point(300, TOP),
        "port_1": Point(420, TOP),
        "port_2": Point(880, TOP),
        "hose_2": Point(1000, TOP),
        "valve_2": Point(1120, TOP),
        "shaft": Point(590, 150),
        "joint": Point(740, 150),
    },
    rails={"tank": Rail(30, 1200, BOTTOM), "frame": Rail(520, 820, 290)},
    bends={"R_in": 38, "2": -36, "3": 36, "4": -36, "qdot_sw": 56},
    flipped=frozenset({"P_s", "1"}),
    couplings=(Coupling("1", 0.2, 0.3, Point(-22, 4)), Coupling("3", 0.3, 0.3)),
    name_shifts={"port_1": -12, "port_2": 14},
    panels={Domain.ROTATION: Box(500, 118, 850, 336)},
)


def _cylinder(before: dict[str, float], after: dict[str, float], bends: dict[str, float]) -> Layout:
    """Return the layout of a cylinder between two rows of nodes, given by x, and further branches' bends."""
    left, right = before["port_1"], after["port_2"]
    middle = (left + right) / 2.0
    row = {name: Point(x, TOP) for name, x in (before | after).items()}
    end = max(after.values()) + 80.0
    return Layout(
        width=int(end) + 40,
        height=420,
        nodes={**row, "piston": Point(middle, 110)},
        rails={"tank": Rail(30, end, BOTTOM), "frame": Rail(middle - 110, middle + 110, 280)},
        bends={"2": -92, "B": -28, "xdot": 28, "3": 92} | bends,
        flipped=frozenset({"P_s", "1"} - bends.keys()),
        couplings=(Coupling("1", 0.3, 0.3), Coupling("4", 0.3, 0.7)),
        panels={Domain.TRANSLATION: Box(middle - 130, TOP, middle + 130, 324)},
    )


def _with_joint(circuit: Layout) -> Layout:
    """Return a cylinder's layout with the joint below the piston, and the tank below the joint."""
    middle, frame = circuit.nodes["piston"].x, circuit.panels[Domain.TRANSLATION]
    bottom, tank = frame.bottom + 230.0, circuit.rails["tank"]
    rails = {
        "tank": Rail(tank.left, tank.right, bottom + 30.0),
        "column": Rail(middle - 110, middle + 110, 510),
    }
    return replace(
        circuit,
        height=int(bottom) + 100,
        nodes=circuit.nodes | {"joint": Point(middle, 380)},
        rails=circuit.rails | rails,
        bends=circuit.bends | {"5": 28, "t_load": -60, "6": 60},
        couplings=(
            Coupling("1", 0.16, 0.3),
            Coupling("4", 0.16, 0.7),
            Coupling("5", 0.85, 0.2, Point(-32, 0)),
        ),
        panels=circuit.panels | {Domain.ROTATION: Box(frame.left, 348, frame.right, bottom)},
    )


BEFORE = {"supply": 60.0, "valve_1": 180.0, "hose_1": 300.0, "port_1": 420.0}
AFTER = {"port_2": 800.0, "hose_2": 920.0, "valve_2": 1040.0}
LONG_BEFORE = {
    "supply": 60.0,
    "valve_1": 170.0,
    "hose_11": 280.0,
    "middle_1": 390.0,
    "hose_12": 500.0,
    "port_1": 610.0,
}
LONG_AFTER = {"port_2": 970.0, "hose_2": 1080.0, "valve_2": 1190.0}

PARALLEL = {"C_1a": -28.0, "1": 28.0, "4": -28.0, "C_2a": 28.0, "C_2v": -28.0, "C_R'": 28.0}
RELIEF = {"C_1": -28.0, "R_v1": 28.0}

CIRCUITS = (
    Circuit("swing", "Swing", swing, SWING),
    Circuit("boom", "Boom and stick", cylinder, _cylinder(BEFORE, AFTER, {})),
    Circuit(
        "boom_joint", "Boom with its joint", cylinder_with_joint, _with_joint(_cylinder(BEFORE, AFTER, {}))
    ),
    Circuit("boom_pi", "Other hoses: pi", cylinder_with_pi_hoses, _cylinder(BEFORE, AFTER, PARALLEL)),
    Circuit(
        "boom_two_lumps",
        "Another hose: two lumps",
        cylinder_with_two_lumps,
        _cylinder(LONG_BEFORE, LONG_AFTER, {}),
    ),
    Circuit("boom_relief", "A relief branch", cylinder_with_relief, _cylinder(BEFORE, AFTER, RELIEF)),
)
