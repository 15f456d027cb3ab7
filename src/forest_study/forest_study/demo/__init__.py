"""The demo, its summary, the reference bags, replays."""
