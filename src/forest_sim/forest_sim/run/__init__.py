"""Runs without a graph: inputs, disturbances, energy account, records on disk, many runs at once."""
