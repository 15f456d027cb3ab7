"""A whole bag from the readable records of a damaged one."""
