"""Bags made of messages with known numbers."""

from bag_fixtures import make_bag

__all__ = ["make_bag"]
