"""The operator's side: input devices, levers and their sources, stick curves, the watch over the joystick."""
