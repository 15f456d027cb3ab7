"""The operator's side: levers and their sources, stick curves, the watch over the joystick."""
