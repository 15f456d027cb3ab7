"""How the machine moves: pump, valves, hoses, actuators, manipulator, integrator, sensors and their node."""
