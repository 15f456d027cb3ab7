"""What the crane and its surroundings look like, told to the page."""
