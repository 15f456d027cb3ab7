"""What is said: topics with types, units, rates and QoS; messages, stamps, definitions."""
