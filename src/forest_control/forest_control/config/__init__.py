"""What a user sets: parameters with units and ranges, profiles, workspaces, joysticks, live changes."""
