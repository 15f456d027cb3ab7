"""The circuits as linear graphs, and their state equations derived from them (chapter 3 of the thesis)."""
