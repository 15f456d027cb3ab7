"""What a metre of the tip costs the pump, and how much of that control could save.

A path of the tip fixes the oil that its actuators take in: area of the inlet times way, added up. That is the
least of any control; what moves to and fro beside it comes on top. The tip is led along paths as
`forest-study track` does it, with sensor noise.

| column | says |
|---|---|
| oil | that the actuators took in for a metre of the tip's path as drawn [l/m] |
| least | that the path alone takes [l/m] |
| work | oil times the pump's pressure then: what the pump gives without its leakage [kJ/m] |
| throttled | of that, what the edges to the inlets and the load-sensing pump's margin take [kJ/m] |
| off | the tip's distance from the path, RMS [mm] |

Poses are 25 ms apart: motion to and fro above 20 Hz is not seen. Leakage is left out.
A load-sensing pump's pressure is taken as its margin over the greatest inlet's, any other's as constant.
"""

import argparse

import numpy as np
from numpy.typing import NDArray

from forest_control.servo.schemes import Scheme
from forest_control.valve import valve_driver_parameters
from forest_description.derived.actuator_kinematics import displacements
from forest_description.derived.limits import pose_at
from forest_description.geometry.linkage import cylinder_length
from forest_description.hydraulics.pump import LoadSensingPump
from forest_description.machine import Machine, load_machine
from forest_study.tracking.paths import path_named
from forest_study.tracking.tracking import Course, follow, noisy, prepare

Floats = NDArray[np.float64]
PATHS = ("sweep", "radial", "vertical")
SPEEDS = (0.25, 0.5, 1.0)  # [m/s]
EVERY = 5  # periods between two poses: noise of an angle is no way
INLETS = np.array([[0, 4, 8], [2, 6, 10]])  # of twelve pressures: valve ports 1 and 2 of swing, boom, stick


def ways(angles: Floats, machine: Machine) -> Floats:
    """Return how the actuators move between poses [rad]: [N - 1, 3] rad, m, m."""
    boom, stick = (
        [cylinder_length(q, linkage) for q in angles[:, i]]
        for i, linkage in enumerate(machine.linkages, start=1)
    )
    return np.diff(np.column_stack([angles[:, 0], boom, stick]), axis=0)


def taken_in(moved: Floats, machine: Machine) -> Floats:
    """Return the oil [m^3] that each inlet takes in for ways of the actuators [N, 3]."""
    one, two = np.array([displacements(machine, axis) for axis in range(3)]).T
    return np.where(moved > 0.0, one * moved, -two * moved)


def row(course: Course, machine: Machine, length: float, seed: int) -> tuple[float, ...]:
    """Return oil, least, work, throttled, off."""
    session = follow(course, machine, noisy(machine, seed))
    moved, least = session.moved, np.array([pose_at(tuple(p), machine) for p in course.places[::EVERY]])
    way = ways(moved.angles[::EVERY], machine)
    oil = taken_in(way, machine)
    pressures = moved.pressures[::EVERY][:-1]
    inlet = np.where(way > 0.0, pressures[:, INLETS[0]], pressures[:, INLETS[1]])
    pump = machine.pump
    supply = np.full(len(oil), pump.idle_pressure)
    if isinstance(pump, LoadSensingPump):
        supply = np.maximum(supply, np.where(oil > 0.0, inlet, 0.0).max(axis=1) + pump.margin)
    work = float((supply[:, None] * oil).sum())
    throttled = work - float((inlet * oil).sum())
    taken = float(taken_in(ways(least, machine), machine).sum())
    told = 1e3 * float(oil.sum()) / length, 1e3 * taken / length
    return (*told, 1e-3 * work / length, 1e-3 * throttled / length, session.total.cross_track_rms_mm)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--machine", nargs="+", default=["c180", "forwarder"], metavar="NAME|FILE")
    parser.add_argument("--dither", type=float, default=-1.0, metavar="V", help="as the driver's setting")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    print("| machine | path | speed, m/s | oil, l/m | least, l/m | work, kJ/m | throttled, kJ/m | off, mm |")
    print("|---|---|---|---|---|---|---|---|")
    drive = valve_driver_parameters.Settings(dither_amplitude=options.dither)
    for machine in map(load_machine, options.machine):
        for name in PATHS:
            path = path_named(name)
            for speed in SPEEDS:
                course = prepare(path, speed, Scheme.COORDINATED, machine)._replace(drive=drive)
                found = row(course, machine, path.length, options.seed)
                told = " | ".join(f"{x:.2f}" for x in found[:2])
                told += f" | {found[2]:.1f} | {found[3]:.1f} | {found[4]:.1f}"
                print(f"| {machine.name} | {name} | {speed:g} | {told} |", flush=True)


if __name__ == "__main__":
    main()
