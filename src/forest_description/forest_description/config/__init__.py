"""Machine files read: YAML with sources and units to numbers with ranges; machines drawn at random."""
