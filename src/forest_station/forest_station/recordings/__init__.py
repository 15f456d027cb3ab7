"""Bags: started, stopped, listed, and cut into frames for a replay."""
