"""How the machine *moves*: hydraulics, mechanics, the implicit solver, sensors, the simulator node.

In the order in which data passes:

- `hydraulics`: Laws of supply, spools, ports, hoses and actuators.
- `mechanics`: Laws of the links, how they bend, the hanging head, gear, dry friction and end stops.
- `equations`: The equations of motion: states, constants, links and drive, put together from the
  parts' laws.
- `midpoint`: What is known at the midpoint of a step (leapfrog): poppets, compensators, flow forces,
  the tank line.
- `stage`: One implicit stage of the equations of motion: hoses exactly, the rest by Newton.
- `solver`: Steps in time, of two stages and second order, interpreted or compiled.
- `sensors`: What the machine's sensors report of its true state.
- `simulation`: Machines under way, without a graph: inputs, disturbances, energy, records, batches.
- `live`: A machine in a graph: its parameters, deadlines and topics, and which voltages it obeys.
- `compiled`: The simulator's kernels, plant and sensors, made beforehand.
- `simulator_node`: The machine as a node: takes /valve_voltages, keeps the graph's time, publishes
  what its sensors report.
- `commander_node`: Says /valve_commands from a file, for experiments with the valves: in place of
  the controller.
- `analysis`: What follows from the equations: modes, checks of a machine file, comparisons, plots.
- `linear_graph`: The circuits as linear graphs, and their state equations derived from them
  (chapter 3 of the thesis).
- `fmi`: The machine as a unit for co-simulation in other tools (FMI 2.0).
- `cli`: `forest-sim`: the simulator from the command line.

May import: `forest_bag`, `forest_msgs_py`, `forest_description`, `forest_compile`.
"""
