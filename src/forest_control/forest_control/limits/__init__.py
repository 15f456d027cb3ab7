"""What bounds a motion: joints, flow, actuator speeds, walls, singular poses."""
