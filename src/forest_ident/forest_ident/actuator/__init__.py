"""One actuator of any scale, fitted to a CSV record."""
