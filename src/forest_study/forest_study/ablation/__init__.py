"""What each constant and each mechanism of control is good for: the same trials with it changed.

In the order in which data passes:

- `constants`: Which numbers `forest_control` has, and how one is changed before a trial.
- `pushes`: After a push, does the tip come to rest where it should?
- `scenes`: Paths, stops, loads, limits: short closed loops in which a change may show.
- `plants`: The matrix' plants, of some of its rows.
- `trials`: All scenes, pushes and plants with some constants changed, in a process of its own.
- `effects`: Which figures a changed constant moves, beyond chance.
- `ablation_command`: `forest-study ablation`: mechanisms left out, constants halved and doubled.
- `bare_loop`: The position loop at rest with no mechanism against limit cycles, simulated.
- `cycles_command`: `forest-study cycles`: its limit cycles, told by describing functions and simulated.
"""
