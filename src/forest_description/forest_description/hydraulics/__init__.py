"""What the oil passes: pump, valves, compensators, load holding, hoses, tank line; with their static laws."""
