"""The standard pictures of a bag."""
