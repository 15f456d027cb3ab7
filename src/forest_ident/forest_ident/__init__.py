"""What the records tell: the recorder and, on top of it, the identification of the machine."""
