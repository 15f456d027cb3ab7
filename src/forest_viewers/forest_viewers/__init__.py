"""How other *tools* see the crane: transforms, markers, a Foxglove server, layouts.

May import: `forest_control`, `forest_bag`, `forest_msgs_py`, `forest_description`.
"""
