"""The thesis's estimators (chapter 4), one parameter or a few at a time."""
