"""Laws of supply and tank line, valves, ports, hoses and actuators."""
