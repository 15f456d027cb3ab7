"""The tip along a path, and how far it is from where it should be."""
