"""Machine, guarded controller and driver in one loop without ROS, interpreted or compiled.

- `closed_loop`: The loop, interpreted, with links and late answers around the cores.
- `link_model`: Transport: links that delay, jitter and lose, and reports as they come in lockstep.
- `path_guide`: An operator who leads the governed reference along a path.
- `loop_core`: One period in numbers alone, for machine code.
- `loop_kernel`: What its machine code is made of, and the loop's beginning.
- `compiled_loop`: Sessions of it, for thousands of runs.
- `model_mismatch`: Machines that differ from what the controller believes.
"""
