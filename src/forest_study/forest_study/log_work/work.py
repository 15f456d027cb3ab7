"""A trial as it went, whoever drove: what the figures are taken from."""

from typing import NamedTuple

from forest_description.machine import Machine
from forest_description.types import Floats
from forest_msgs_py.types import PERIOD
from forest_study.log_work.crane import LOOK
from forest_study.log_work.site import Site

LONGEST = 240.0  # [s] of a trial
SLOW = 0.15  # [m/s] of the grip at which a grapple is closed or opened; assumed
LOOK_TIME = LOOK * PERIOD


class Work(NamedTuple):
    """A trial as it went, a row a look."""

    machine: Machine
    site: Site
    angles: Floats  # [N, 3] rad
    head: Floats  # [N, 2] rad
    tip: Floats  # [N, 3] m
    levers: Floats  # [N, 3]
    engine: Floats  # [N] J
    number: Floats  # [N] of the carry or way
    part: tuple[str, ...]  # N parts of it
    loaded: Floats  # [N] 1 while a log is in the grapple
