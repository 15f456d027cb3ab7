"""Pages and sockets, and who may open them."""
