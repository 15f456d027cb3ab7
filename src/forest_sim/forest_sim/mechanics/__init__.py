"""Laws of the links, how they bend, the hanging head, gear, dry friction and end stops."""
