"""Memory of a process that steps the simulated machine as its node does, without ROS, for hours of its time.

    python benchmarks/machine_memory.py [--hours 2] [--machine c180]

Python keeps memory for objects of each size that it has once needed; that ends, a leak does not.
"""

import argparse
import math
from pathlib import Path

from forest_description.derived.limits import start_tip
from forest_description.machine import load_machine
from forest_msgs_py.types import PERIOD
from forest_sim.live.simulator_parameters import SimulatorParameters, simulated_machine
from forest_sim.simulation.sensor_log import further_topics, topic_values

ROW = 600.0  # [s] of the machine's time
VOLTS = 2.0  # [V] to and fro: the oil warms, so that the machine's numbers change each second


def main() -> None:
    """Print a row each ten minutes of the machine's time."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hours", type=float, default=2.0)
    parser.add_argument("--machine", default="c180")
    options = parser.parse_args()
    described = load_machine(options.machine)
    machine = simulated_machine(described, SimulatorParameters(initial_tip=start_tip(described)), PERIOD)
    further = further_topics(described, has_loads=True)
    print("| after, min | own memory, MB |\n|---|---|")
    for row in range(1, round(options.hours * 3600.0 / ROW) + 1):
        for period in range(round(ROW / PERIOD)):
            volts = VOLTS * math.sin(2.0 * math.pi * PERIOD * period)
            topic_values(machine.step((volts, volts, volts)), machine.events, 0)
            for told in further.values():
                told(machine)
        print(f"| {row * ROW / 60.0:.0f} | {own_memory():.2f} |", flush=True)


def own_memory() -> float:
    """Return what this process shares with no file and no other process [MB]."""
    status = Path("/proc/self/status").read_text()
    return int(status.partition("RssAnon:")[2].split()[0]) / 1024.0


if __name__ == "__main__":
    main()
