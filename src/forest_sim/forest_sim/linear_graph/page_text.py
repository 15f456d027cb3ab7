"""What docs/explanation/linear-graphs.md says in words; `page` writes it around the equations."""

INTRODUCTION = """# Linear graphs

`python -m forest_sim.linear_graph.page` writes this page; do not edit it by hand.

Each actuation subsystem is a linear graph, as in sections 3.3 and 3.4 of the thesis.
The graph is data (`forest_sim.linear_graph.actuation_graphs`).
`forest_sim.linear_graph.state_equations` derives the state equations from it.
Tests compare them with the simulator's equations (`test_actuation_graphs.py`).
Misprints of the printed derivation are listed in [equations](equations.md#misprints-corrected).

## How to read a graph

- The arrow is the positive direction of a branch.
- The across variable (pressure P, angular velocity W, velocity V) drops along the arrow.
- The through variable (flow Q, torque t, force F) runs along the arrow.
- Bold branches are the normal tree. Thin branches are links; each closes one loop with the tree.
- A pump that delivers has a negative flow.
- The through variable of a velocity source is the torque or force on the load.
- Port 1 of the valve is open to the supply, port 2 to the tank.

## How the equations follow

1. The normal tree takes branches in this order: across sources; as many A-type storages
   (capacitances) as possible; one branch of each transformer; both branches or none of each
   gyrator; D-types (resistances); T-type storages (inertances).
2. The states are the across variables of the A-types in the tree, and the through variables of
   the T-types outside it.
   A storage that depends on these is merged with them. An inertia J₂ behind a gear of ratio N
   adds N² J₂; capacitances at one node add up.
3. Each link gives one **compatibility** equation: the across variables of its loop.
4. Each branch of the tree gives one **continuity** equation: the through variables of its cut-set.
5. With the laws of the elements, there are as many equations as unknowns. What is neither state
   nor input is eliminated.

## How to change a circuit

Change its branches. This needs sympy: `scripts/setup.sh test`, or
`pip install 'forest-crane[graphs]'`.

```python
from forest_sim.linear_graph.actuation_graphs import cylinder
from forest_sim.linear_graph.linear_graph import Branch, Kind
from forest_sim.linear_graph.state_equations import state_equations

relief = Branch("R_v1", Kind.D_TYPE, "hose_1", "tank", "R_v1")
equations = state_equations(cylinder().changed("boom with relief", add=[relief]))
print(dict(zip(equations.states, equations.derivatives)))
print(equations.through["xdot"])  # force on the load
```

An impossible circuit is refused with the names of its elements. Impossible are:

- unconnected parts;
- a loop of across sources, or a cut-set of through sources;
- a storage that depends on an input or on a changing ratio;
- a quadratic element whose law is not explicit. Two of them at one port, as an underlapped valve
  has, are allowed (`cylinder_with_underlap`): their pair of laws has a closed form,
  `forest_sim.linear_graph.quadratic.shunt_flow`.

## How to run a circuit

`forest_sim.linear_graph.graph_run.run` integrates the state equations with numbers.
It returns every variable of the circuit over time.
This opens the boom's valve of `c180_thesis` to 4 V. The piston's speed rises to 0.05 m/s.

```python
import numpy as np

from forest_description.hydraulics.valve_characteristic import edges
from forest_description.machine import load_machine
from forest_sim.linear_graph.actuation_graphs import cylinder
from forest_sim.linear_graph.actuation_parameters import actuation_parameters
from forest_sim.linear_graph.graph_run import run
from forest_sim.linear_graph.state_equations import state_equations

machine = load_machine("c180_thesis")
valve = edges(4.0, machine.valve_of(1).law)
over_time = run(
    state_equations(cylinder()),
    inputs={"P_s": machine.pump.supply_pressure, "xdot": lambda t, states: 0.05 * np.tanh(t / 0.1)},
    parameters=actuation_parameters(machine, "boom", valve.supply_1, valve.tank_2),
    start={"P_C_1": 8e6, "P_C_2": 2e6},  # what is left out starts at zero
    times=np.linspace(0.0, 1.0, 201),
)
for name in ("P_1", "Q_I_1", "F_xdot"):
    print(f"{name} {over_time[name][-1]:.4g}")
```

It prints the head side's pressure [Pa], its flow [m³/s] and the force on the load [N] after 1 s:

```text
P_1 1.282e+07
Q_I_1 0.000912
F_xdot 1.678e+05
```

`test_graph_run.py` runs swing and boom with the speed that the simulator's plant has.
Over a second of open valve, pressures and flows agree within 0.02 % of their range.

A lever arm is a **modulated** two-port: its ratio is an input.
`cylinder_with_joint` puts the lever arm and the joint's inertia in place of the given speed.
The angle is a displacement of the run, the integral of the joint's speed:

```text
inputs={"arm": lambda t, states: lever_arm(states["q"], machine.boom.linkage), ...},
displacements={"q": "J"}
```

The same test runs it against the simulator: the angle agrees within 0.02 % of its range, too.
A ratio that becomes zero has no solution where the equations divide by it: a linkage's dead point.
"""

NOTES = {
    "swing": """\
Thesis fig. 3.8. Branches 1 and 2 are the motor, 3 and 4 the gear train.
P₁ is the pressure across the motor.
The torque on the load is the through variable of the swing's velocity source.""",
    "boom": """\
Thesis fig. 3.9. The stick has the same graph.
Branches 1 and 2 are the head side of the piston, 4 and 3 its rod side.
Q₄ counts into the rod side, as in eq. 3.11; the flow of R₂ leaves the cylinder.
The force on the load is the through variable of the piston's velocity source.""",
    "boom_joint": """\
Branches 5 and 6 are the lever arm d(piston)/d(angle) of eq. 3.16: a modulated transformer.
The torque of the load is gravity's and that of the other links.""",
    "boom_pi": """\
Half of each hose's capacitance stands at either end.
Each orifice lies between two pressures that are states or inputs, so it is a link.
Its law is used in the other direction: flow from pressure drop.""",
    "boom_two_lumps": """\
Hose 1 has two lumps. This adds two states.""",
    "boom_relief": """\
An open relief valve with a linear characteristic joins hose 1 to the tank. This adds one term.""",
}
