"""Bags of everyday work with a crane that has drifted, for `forest-ident fit --from-driving`.

    python benchmarks/everyday_bags.py DIR [--minutes 30] [--seed 1]
    forest-ident fit --from-driving DIR/bags --start c180_hoses --truth DIR/drifted.yaml --out found.yaml

Each bag is five minutes of a seeded hand on the levers, in a closed loop with the drifted crane, whose
controller believes in the start file. In each a log is carried for a minute. `DIR/drifted.yaml` is the crane.
"""

import argparse
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test" / "helpers"))

from everyday_work import DRIFTED, everyday_work

from forest_description.machine import load_machine
from forest_ident.measurements import session_bag
from forest_sim.simulation.load_schedule import parse_loads

MINUTES = 5.0  # [min] of a bag
LOG = "300 kg from 100 s; 0 kg from 160 s"


def main() -> None:
    """Write the bags."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("directory", type=Path, metavar="DIR")
    parser.add_argument("--minutes", type=float, default=30.0, metavar="MIN")
    parser.add_argument("--seed", type=int, default=1, help="of the first bag")
    options = parser.parse_args()
    (options.directory / "bags").mkdir(parents=True)
    file = options.directory / "drifted.yaml"
    file.write_text(DRIFTED, encoding="utf-8")
    machine, start = load_machine(file), load_machine("c180_hoses")
    for place in range(max(1, round(options.minutes / MINUTES))):
        seconds = 60.0 * min(MINUTES, options.minutes)
        work = everyday_work(machine, start, options.seed + place, seconds, parse_loads(LOG))
        session_bag.write(work, options.directory / "bags" / f"work_{place + 1:02d}")


if __name__ == "__main__":
    main()
