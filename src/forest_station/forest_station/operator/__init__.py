"""Who drives, and whether the deadman is held: the machine's side of a hand in a browser."""
