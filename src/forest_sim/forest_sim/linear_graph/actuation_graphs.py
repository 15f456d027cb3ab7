"""The thesis' circuits of swing, boom and stick as linear graphs, and changed ones.

Port 1 is connected to the supply and port 2 to the tank, the thesis' only case. Hose 1 counts from
the valve to the actuator, hose 2 from the actuator to the valve. Node names are those of the
crane's places. What the graph leaves to the manipulator is a velocity source: its through variable
is the torque or force on the load.

`page` draws them and writes what follows from them into docs/explanation/linear-graphs.md.

| symbol | name | unit |
|---|---|---|
| P_s | supply pressure | Pa |
| C_R, C_R' | orifices of the spool towards port 1, from port 2 | Pa s^2/m^6 |
| C_T1, C_S2 | orifices of an underlapped spool from port 1 to the tank, towards port 2 | Pa s^2/m^6 |
| I, C, R | inertance, capacitance, resistance of hose 1, 2 | Pa s^2/m^3, m^3/Pa, Pa s/m^3 or Pa s^2/m^6 |
| R_in, R_e1, R_e2 | leakage of the motor: across it, from its ports to the case drain | Pa s/m^3 |
| D_m, N | displacement of the motor, ratio of the gear train | m^3/rad, 1 |
| gy_1, gy_2 | piston areas, head and rod side | m^2 |
| B_sw, B | viscous damping | N m s/rad, N s/m |
| qdot_sw, xdot | swing rate, piston speed, inputs | rad/s, m/s |
| arm, t_load | lever arm of the joint, torque of gravity and of other links on it, inputs | m, N m |
| J | inertia about the joint | kg m^2 |
"""

from forest_sim.linear_graph.linear_graph import Branch, Domain, Kind, LinearGraph

TANK = "tank"
FRAME = "frame"
COLUMN = "column"


def swing() -> LinearGraph:
    """Return the swing: valve, two laminar T hoses, leaking motor, gear train.

    Thesis section 3.3, fig. 3.8, eq. 3.4-3.6. Branches 1-2 are the motor, 3-4 the gear train.
    """
    rotation = Domain.ROTATION
    return LinearGraph(
        "swing",
        (
            Branch("P_s", Kind.ACROSS_SOURCE, "supply", TANK, "P_s"),
            Branch("C_R", Kind.QUADRATIC, "supply", "valve_1", "C_R"),
            Branch("I_1", Kind.T_TYPE, "valve_1", "hose_1", "I_1"),
            Branch("C_1", Kind.A_TYPE, "hose_1", TANK, "C_1"),
            Branch("1", Kind.GYRATOR, "port_1", "port_2", "D_m", partner="2"),
            Branch("2", Kind.GYRATOR, "shaft", FRAME, "D_m", rotation, "1"),
            Branch("3", Kind.TRANSFORMER, "shaft", FRAME, "N", rotation, "4"),
            Branch("4", Kind.TRANSFORMER, "joint", FRAME, "N", rotation, "3"),
            Branch("B_sw", Kind.D_TYPE, "joint", FRAME, "B_sw", rotation),
            Branch("qdot_sw", Kind.ACROSS_SOURCE, "joint", FRAME, "qdot_sw", rotation),
            # Of equal D-types the earlier enters the tree: in this order it is the tree of eq. 3.4.
            Branch("R_in", Kind.D_TYPE, "port_1", "port_2", "R_in"),
            Branch("R_2", Kind.D_TYPE, "port_2", "hose_2", "R_2"),
            Branch("R_1", Kind.D_TYPE, "hose_1", "port_1", "R_1"),
            Branch("R_e1", Kind.D_TYPE, "port_1", TANK, "R_e1"),
            Branch("R_e2", Kind.D_TYPE, "port_2", TANK, "R_e2"),
            Branch("C_2", Kind.A_TYPE, "hose_2", TANK, "C_2"),
            Branch("I_2", Kind.T_TYPE, "hose_2", "valve_2", "I_2"),
            Branch("C_R'", Kind.QUADRATIC, "valve_2", TANK, "C_R'"),
        ),
    )


def cylinder(name: str = "boom") -> LinearGraph:
    """Return boom or stick: valve, two turbulent T hoses, a single-ended cylinder as two gyrators.

    Thesis section 3.4, fig. 3.9, eq. 3.10-3.12. Branches 1-2 are the head side, 4-3 the rod side.
    Branch 3 points from the frame to the piston, so that P_4 is the pressure at port 2 and pushes
    the piston back; Q_4 is the flow into the rod side, as in 3.11.
    """
    translation = Domain.TRANSLATION
    return LinearGraph(
        name,
        (
            Branch("P_s", Kind.ACROSS_SOURCE, "supply", TANK, "P_s"),
            Branch("C_R", Kind.QUADRATIC, "supply", "valve_1", "C_R"),
            Branch("I_1", Kind.T_TYPE, "valve_1", "hose_1", "I_1"),
            Branch("C_1", Kind.A_TYPE, "hose_1", TANK, "C_1"),
            Branch("R_1", Kind.QUADRATIC, "hose_1", "port_1", "R_1"),
            Branch("1", Kind.GYRATOR, "port_1", TANK, "gy_1", partner="2"),
            Branch("2", Kind.GYRATOR, "piston", FRAME, "gy_1", translation, "1"),
            Branch("B", Kind.D_TYPE, "piston", FRAME, "B", translation),
            Branch("xdot", Kind.ACROSS_SOURCE, "piston", FRAME, "xdot", translation),
            Branch("4", Kind.GYRATOR, "port_2", TANK, "gy_2", partner="3"),
            Branch("3", Kind.GYRATOR, FRAME, "piston", "gy_2", translation, "4"),
            Branch("R_2", Kind.QUADRATIC, "port_2", "hose_2", "R_2"),
            Branch("C_2", Kind.A_TYPE, "hose_2", TANK, "C_2"),
            Branch("I_2", Kind.T_TYPE, "hose_2", "valve_2", "I_2"),
            Branch("C_R'", Kind.QUADRATIC, "valve_2", TANK, "C_R'"),
        ),
    )


def cylinder_with_pi_hoses() -> LinearGraph:
    """Return the boom with half of each hose's capacitance at either end, the rest between."""
    return cylinder().changed(
        "boom, pi hoses",
        remove=("I_1", "C_1", "R_1", "R_2", "C_2", "I_2"),
        add=(
            Branch("C_1v", Kind.A_TYPE, "valve_1", TANK, "C_1v"),
            Branch("R_1", Kind.QUADRATIC, "valve_1", "hose_1", "R_1"),
            Branch("I_1", Kind.T_TYPE, "hose_1", "port_1", "I_1"),
            Branch("C_1a", Kind.A_TYPE, "port_1", TANK, "C_1a"),
            Branch("C_2a", Kind.A_TYPE, "port_2", TANK, "C_2a"),
            Branch("I_2", Kind.T_TYPE, "port_2", "hose_2", "I_2"),
            Branch("R_2", Kind.QUADRATIC, "hose_2", "valve_2", "R_2"),
            Branch("C_2v", Kind.A_TYPE, "valve_2", TANK, "C_2v"),
        ),
    )


def cylinder_with_two_lumps() -> LinearGraph:
    """Return the boom with hose 1 in two lumps, for waves that one lump is too short for."""
    return cylinder().changed(
        "boom, hose 1 in two lumps",
        remove=("I_1", "C_1", "R_1"),
        add=(
            Branch("I_11", Kind.T_TYPE, "valve_1", "hose_11", "I_11"),
            Branch("C_11", Kind.A_TYPE, "hose_11", TANK, "C_11"),
            Branch("R_11", Kind.QUADRATIC, "hose_11", "middle_1", "R_11"),
            Branch("I_12", Kind.T_TYPE, "middle_1", "hose_12", "I_12"),
            Branch("C_12", Kind.A_TYPE, "hose_12", TANK, "C_12"),
            Branch("R_12", Kind.QUADRATIC, "hose_12", "port_1", "R_12"),
        ),
    )


def cylinder_with_relief() -> LinearGraph:
    """Return the boom with an open relief valve at hose 1's capacitance, a linear path to the tank."""
    return cylinder().changed(
        "boom, relief branch", add=(Branch("R_v1", Kind.D_TYPE, "hose_1", TANK, "R_v1"),)
    )


def cylinder_with_joint() -> LinearGraph:
    """Return the boom with its joint instead of a given piston speed: a lever arm turns an inertia.

    Thesis eq. 3.16. The arm d(piston)/d(angle) goes with the angle: branches 5-6 are modulated.
    """
    rotation = Domain.ROTATION
    return cylinder().changed(
        "boom with its joint",
        remove=("xdot",),
        add=(
            Branch("5", Kind.TRANSFORMER, "piston", FRAME, "arm", Domain.TRANSLATION, "6", modulated=True),
            Branch("6", Kind.TRANSFORMER, "joint", COLUMN, "arm", rotation, "5", modulated=True),
            Branch("J", Kind.A_TYPE, "joint", COLUMN, "J", rotation),
            Branch("t_load", Kind.THROUGH_SOURCE, COLUMN, "joint", "t_load", rotation),
        ),
    )


def cylinder_with_underlap() -> LinearGraph:
    """Return the boom with an underlapped valve near its centre: each port is open to supply and tank."""
    return cylinder().changed(
        "boom, underlapped valve",
        add=(
            Branch("C_T1", Kind.QUADRATIC, "valve_1", TANK, "C_T1"),
            Branch("C_S2", Kind.QUADRATIC, "supply", "valve_2", "C_S2"),
        ),
    )
