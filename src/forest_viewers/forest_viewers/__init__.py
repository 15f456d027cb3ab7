"""How other *tools* see the crane: transforms, markers, a Foxglove server, layouts.

Rooms, in the order in which data passes through them:

- `crane`: the crane as it is drawn: all joints, frames, trails, work area, walls; pure.
- `server`: what a Foxglove or Lichtblick client sees of a graph, and what it may ask.
- `recorded`: a bag's frames added, so that a viewer shows the crane from a file.
- `viewer_node`, `foxglove_node`: transforms and markers as a node; a Foxglove server as a node.
- `layouts`: files for Foxglove, Lichtblick, PlotJuggler, RViz and `ros2 bag`.

May import: `forest_control`, `forest_bag`, `forest_msgs_py`, `forest_description`.
"""
