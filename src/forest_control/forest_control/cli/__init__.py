"""`forest-control` from the command line: taught work."""
