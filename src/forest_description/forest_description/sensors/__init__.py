"""What is measured: the sensors by kind, and what their calibration found."""
