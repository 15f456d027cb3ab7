"""The valve driver: deadband, gain and pressure drop compensated and adapted."""
