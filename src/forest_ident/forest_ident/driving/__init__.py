"""An experiment carried out: on a simulated machine or on a running graph, within its bounds."""
