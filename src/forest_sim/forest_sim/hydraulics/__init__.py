"""Laws of supply, spools, ports, hoses and actuators."""
