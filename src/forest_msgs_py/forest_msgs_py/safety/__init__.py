"""What every node does about danger: the emergency stop, also where two command, and diagnostics."""
