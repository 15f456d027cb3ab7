"""Two bags side by side: to the last bit or within a tolerance."""
