"""What a step knows of its middle: poppets, compensators, flow forces, the tank line."""
