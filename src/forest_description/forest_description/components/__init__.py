"""What a crane is made of: pump, valves, hoses, oil, actuators, sensors, load; with their static laws."""
