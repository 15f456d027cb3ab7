"""The crane as lines in space: tip kinematics, and the triangles of the cylinders' linkages."""
