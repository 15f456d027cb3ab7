"""Bags to tables, and measured logs to bags."""
