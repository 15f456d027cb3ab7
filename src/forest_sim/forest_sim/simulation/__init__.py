"""Machines under way, with or without a graph: inputs, disturbances, energy, records, batches."""
