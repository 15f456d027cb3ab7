"""A machine as text: a machine file, and the tables of docs/."""
