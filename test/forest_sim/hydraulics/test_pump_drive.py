"""Claims about swash plate and engine: their laws, their limits, and their implicit steps."""

import math

import numpy as np
import pytest
from driven_pump import DOWN, ENGINE, SWASHED, UP, driven

from forest_sim.hydraulics.pump_drive import (
    NO_DRIVE,
    Sloped,
    engine_torque,
    pump_drive,
    speed_after,
    stroke_after,
    stroke_rate,
)

DRIVE = pump_drive(driven("load sensing", **SWASHED, engine=ENGINE).pump)
STRONG = pump_drive(driven("load sensing", engine=ENGINE, engine_power=8e4).pump)  # 80 kW: less than 400 N m


def test_a_swash_plate_goes_up_and_down_with_its_time_constants():
    assert stroke_rate(0.4, 1.0, DRIVE) == pytest.approx(0.6 / UP)
    assert stroke_rate(0.4, 0.1, DRIVE) == pytest.approx(-0.3 / DOWN)


def test_an_implicit_step_of_the_plate_fulfils_its_law_and_tells_its_slope():
    for before, asked, step in ((0.2, 0.9, 1e-3), (0.9, 0.2, 1e-3), (0.5, 0.5, 0.1), (0.0, 1.0, 10.0)):
        after = stroke_after(before, Sloped(asked, -1e-6), step, DRIVE)
        assert after.value == pytest.approx(before + step * stroke_rate(after.value, asked, DRIVE), rel=1e-12)
        more = stroke_after(before, Sloped(asked - 1e-7, 0.0), step, DRIVE)
        assert more.value - after.value == pytest.approx(0.1 * after.slope, rel=1e-6)
        assert 0.0 <= after.value <= 1.0
    assert stroke_after(0.2, Sloped(0.9, -1e-6), 1e-3, NO_DRIVE) == Sloped(0.9, -1e-6)


def test_the_governor_droops_up_to_the_greatest_torque():
    n_0 = DRIVE.speed
    for share in (0.0, 0.3, 1.0):
        assert engine_torque(n_0 * (1.0 - ENGINE.droop * share), DRIVE) == pytest.approx(share * 400.0)
    assert engine_torque(0.8 * n_0, DRIVE) == 400.0
    assert engine_torque(1.1 * n_0, DRIVE) == 0.0
    assert engine_torque(0.8 * n_0, STRONG) == pytest.approx(8e4 / (0.8 * n_0))


def test_an_engine_under_its_stall_speed_gives_nothing():
    assert engine_torque(84.0, DRIVE) == engine_torque(0.0, DRIVE) == 0.0
    assert speed_after(80.0, 100.0, 1e-3, DRIVE) == pytest.approx(80.0 - 1e-3 / 2.0 * 100.0)
    assert speed_after(0.01, 100.0, 1e-3, DRIVE) == speed_after(0.0, 0.0, 1e-3, DRIVE) == 0.0


@pytest.mark.parametrize("drive", [DRIVE, STRONG], ids=["torque", "power"])
def test_an_implicit_step_of_the_engine_fulfils_its_law(drive):
    rng = np.random.default_rng(4)
    seen = set()
    for _ in range(300):
        before, load, step = rng.uniform(120.0, 300.0), rng.uniform(-50.0, 600.0), 10.0 ** rng.uniform(-4, -1)
        after = speed_after(before, load, step, drive)
        if after <= drive.stall:
            continue
        torque = engine_torque(after, drive)
        assert drive.inertia * (after - before) == pytest.approx(step * (torque - load), abs=1e-9)
        seen.add((torque == 0.0, torque == drive.torque, 0.0 < torque < drive.torque))
    assert len(seen) == 3
    assert not math.isnan(speed_after(before, 1e9, 1.0, drive))


def test_a_pump_without_engine_turns_at_its_speed():
    plate = pump_drive(driven("compensated", **SWASHED).pump)
    assert speed_after(100.0, 1e4, 1.0, plate) == plate.speed
    assert pump_drive(driven("compensated").pump) == NO_DRIVE
