"""Logs from the ground to the bunk and back: the work of which cycle times are told.

In the order in which data passes:

- `site`: Where logs, bunk, ground and wheels are, scaled to the machine's reach.
- `task`: The standard task of the boom-tip studies: seven carries and ways, each in legs.
- `person`: An operator's numbers, each with its source, from a file; practice changes them.
- `manual_control`: What that operator says by three levers, joint by joint or of the tip.
- `crane`: The machine in closed loop, moved a look of the operator at a time.
- `work`: A trial as it went.
- `taught`: The task as a taught cycle that is played.
- `trial`: The task done once.
- `clearance`: How near crane and log come to ground, bunk and stakes; contacts.
- `trial_measures`: The figures of a trial.

May import: `closed_loop`, `tracking`, `results`.
"""
