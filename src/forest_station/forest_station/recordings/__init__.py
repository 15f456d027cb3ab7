"""Bags: started, stopped, listed, and cut into frames for a replay.

In the order in which data passes:

- `bag_directory`: which bags there are, and which names are allowed: whoever asks may be anybody.
- `recorder_process`: the project's recorder as a process of the station's, begun and ended with each bag.
- `replay_bag`: a bag opened for the page: span, signals, events, crane.
- `replay_crane`: what its crane looks like, and where its passive joints are.
- `replay_frames`: a window of it as frames, as a live crane sends them.
- `replay_worker`: both in a process of their own, so that no bag delays what drives the crane.
- `recordings`: all of these together, as the server has them.
"""
