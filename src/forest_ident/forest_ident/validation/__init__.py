"""A model against a record that it was not fitted to; `verdict` decides the exit code of a fit."""
