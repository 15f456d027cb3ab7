"""`forest-ident`: a module for each verb."""
