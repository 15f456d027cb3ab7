"""How the nodes talk, live and on disk: topic table, arrays and messages, bags, pictures, node frame."""
