"""The crane as URDF, for viewers and for `/robot_description`."""
