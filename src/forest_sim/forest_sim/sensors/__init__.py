"""What the machine's sensors report of its true state."""
