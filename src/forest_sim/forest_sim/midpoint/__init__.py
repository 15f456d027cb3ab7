"""What is known at the midpoint of a time step: poppets, compensators, flow forces, the tank line."""
