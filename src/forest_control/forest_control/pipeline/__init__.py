"""The controller's step from levers to commands of ideal valves."""
