"""What was found, as a page, pictures and a machine file."""
