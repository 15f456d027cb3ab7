"""Machines whose pump has a swash plate that takes time, an engine that droops, and a tank line."""

import dataclasses

from full_machine import PUMPS, with_pump

from forest_description.hydraulics.pump import Engine
from forest_description.hydraulics.tank_line_parameters import TankLine
from forest_description.machine import Machine, load_machine

UP, DOWN = 0.03, 0.02
ENGINE = Engine(inertia=2.0, droop=0.1, torque=400.0, stall_speed=84.0)
TANK_LINE = TankLine(preload=2e5, resistance=4.5e10, capacitance=1.5e-11)
SWASHED = {"stroke_up_time": UP, "stroke_down_time": DOWN}
C180 = load_machine("c180_hoses")
assert set(PUMPS) > {"compensated", "load sensing"}


def driven(
    name: str, machine: Machine = C180, tank_line: TankLine | None = None, **changes: object
) -> Machine:
    """Return a machine with a pump, changed, and a tank line."""
    return dataclasses.replace(with_pump(name, machine, **changes), tank_line=tank_line)


def everything(name: str, machine: Machine = C180) -> Machine:
    """Return a machine with swash plate, torque limiter, engine and tank line."""
    return driven(name, machine, TANK_LINE, **SWASHED, torque_limit=250.0, engine=ENGINE)
