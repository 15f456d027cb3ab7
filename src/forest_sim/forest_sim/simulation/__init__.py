"""Machines under way, without a graph: inputs, disturbances, energy, records."""
