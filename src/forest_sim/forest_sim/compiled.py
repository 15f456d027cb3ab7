"""The simulator's kernels, plant and sensors: `python -m forest_sim.compiled` makes what its node needs."""

import sys

from forest_compile import kernel_cache
from forest_sim.sensors.sensor_run import KERNEL as SENSORS
from forest_sim.solver.plant_kernel import KERNEL as PLANT


def main() -> None:
    """Make the machine code if it is not there, and tell where it is."""
    sys.exit(kernel_cache.make(PLANT, SENSORS))


if __name__ == "__main__":
    main()
