"""Running estimates while the machine works."""
