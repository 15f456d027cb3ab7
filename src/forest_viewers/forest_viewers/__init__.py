"""How other *tools* see the crane: transforms, markers, a Foxglove server, layouts.

Rooms, in the order in which data passes through them:

- `crane`: the crane as it is drawn: all joints, frames, trails, work area, walls; pure.
- `server`: what a Foxglove or Lichtblick client sees of a graph, and what it may ask.

May import: `forest_control`, `forest_bag`, `forest_msgs_py`, `forest_description`.
"""
