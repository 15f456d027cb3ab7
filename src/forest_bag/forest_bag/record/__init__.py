"""A recording session: which topics, what the bag says of the run, how it is going."""
