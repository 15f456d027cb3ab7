"""A Gymnasium environment of the closed loop, and what our controller reaches in it.

- `tasks`: What is to be done: follow a drawn path, or reach drawn targets; rewards and figures.
- `driven_crane`: The crane under an action: by levers through our controller, or by valve voltages.
- `crane_env`: The environment `ForestCrane-v0`; the only module that needs gymnasium.
- `policies`: Our controller led by a simple hand, resolved rates, chance, rest.
- `baseline_command`: Every policy on the same seeds: `forest-study baseline`.
"""
