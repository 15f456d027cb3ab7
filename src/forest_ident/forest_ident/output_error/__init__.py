"""Output error: the simulator's readings against the recorded ones."""
