"""`forest-bag`: a module for each verb."""
