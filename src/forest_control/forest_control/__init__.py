"""How the operator's wish becomes voltage: joystick, schemes, governor, valve driver; their nodes."""
