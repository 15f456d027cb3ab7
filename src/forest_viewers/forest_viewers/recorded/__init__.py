"""Bags for viewers: the frames added that show the crane where a file is dragged into a window."""
