"""What the oil moves: actuators with gear and friction, links that bend, end stops, head and load."""
