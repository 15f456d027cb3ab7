"""The experiments: what a person prepares, what is driven, how far."""
