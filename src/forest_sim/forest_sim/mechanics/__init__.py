"""Laws of the rigid links, the hanging head, gear, dry friction and end stops."""
