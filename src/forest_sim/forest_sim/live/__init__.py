"""A machine in a graph: its parameters, deadlines and topics, and which voltages it obeys."""
