"""What a Foxglove or Lichtblick client sees of a graph, and what it may ask; without ROS."""
