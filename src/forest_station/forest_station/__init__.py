"""The operator's page: what a person *sees*, and the hand that drives, in a browser.

Rooms, in the order in which data passes through them:

- `operator`: who drives, and whether the deadman is held; pure.
- `graph`: the ROS side: signals of all topics, parameters, services, the joystick's messages.
- `scene`: what the crane and its surroundings look like, for the page.
- `recordings`: bags: started, stopped, listed, and cut into frames for a replay.
- `server`: pages, sockets, and who may open them.
- `station_node`: the station as a node.
- `web`: the page itself: one panel a file; the drawn crane is in `web/scene`.

May import: `forest_bringup`, `forest_control`, `forest_bag`, `forest_msgs_py`, `forest_description`.
"""
