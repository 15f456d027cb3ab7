"""Whether a measured state can be believed."""
