"""What every node does about danger: the emergency stop, and diagnostics of its inputs."""
