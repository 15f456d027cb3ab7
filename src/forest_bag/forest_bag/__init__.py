"""What is *recorded*: MCAP bags written, read, repaired, played, compared, converted and drawn.

In the order in which data passes:

- `storage`: Files on disk: MCAP chunk by chunk, SQLite of older bags, `metadata.yaml`.
- `write`: A bag as it grows: files, splits, what each file begins with.
- `record`: A recording session: which topics, what the bag says of the run, how it is going.
- `recorder_node`: The recorder node: every topic it can see, as raw bytes, into a bag.
- `read`: A bag read: raw messages in order of time, tables, time series, a survey of what is in it.
- `recovery`: A whole bag from the readable records of a damaged one; `metadata.yaml` made anew.
- `play`: A bag played in time: what is asked for, reading ahead, timing, remote control.
- `player_node`: The player node: raw bytes from a bag onto their topics, with the QoS they were recorded
  with.
- `step_player_node`: Plays a bag in lockstep: publishes the messages of step k, and waits for the answers.
- `compare`: Two bags side by side: to the last bit or within a tolerance.
- `convert`: Bags to other bags and to tables, and measured logs to bags.
- `plots`: The standard pictures of a bag.
- `cli`: `forest-bag`: a module for each verb.

May import: `forest_msgs_py`, `forest_description`.
"""
