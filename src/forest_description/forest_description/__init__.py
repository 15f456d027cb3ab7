"""What the crane *is*: parameters, linkages, kinematics, limits, URDF.

In the order in which data passes:

- `types`: Numbers per axis, points in space, arrays: what every package counts in.
- `config`: Machine files read: YAML with sources and units to numbers with ranges; machines drawn
  at random.
- `geometry`: The crane as lines in space: tip kinematics, and the triangles of the cylinders'
  linkages.
- `hydraulics`: What the oil passes: pump, valves, compensators, load holding, hoses, tank line;
  with their static laws.
- `mechanics`: What the oil moves: actuators with gear and friction, links that bend, end stops, head
  and load.
- `sensors`: What is measured: the sensors by kind, and what their calibration found.
- `machine`: The crane as numbers: pump, valve, hoses, actuators, manipulator, sensors; all SI,
  frozen, range-checked.
- `derived`: What follows from a machine's numbers: limits, speeds, bodies, warm and cold oil, the
  hoses' bandwidth.
- `urdf`: The crane as URDF, for viewers and for `/robot_description`.
- `export`: A machine as text: a machine file, and the tables of docs/.

May import: `forest_compile`.
"""
