"""Laws of the rigid links, the hanging head, dry friction and end stops."""
