"""The thesis's evaluation of its control schemes (chapter 5), run anew."""
