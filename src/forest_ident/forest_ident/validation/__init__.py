"""A model against a record that it was not fitted to."""
