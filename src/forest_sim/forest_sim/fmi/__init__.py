"""The machine as a unit for co-simulation in other tools (FMI 2.0)."""
