"""How fast a joint may go, told to the page: it names the joint on which the limit `rate` acts."""

import math

import numpy as np
import pytest

from forest_control.config.controller_settings import Settings, parameters
from forest_control.limits.velocity_scaling import Limit, velocity_scaling
from forest_control.pipeline.motion_limits import velocity_limits_at
from forest_description.derived.limits import joint_limits
from forest_description.geometry.kinematics import is_singular, joint_rates
from forest_description.machine import load_machine
from forest_description.types import AXES
from forest_station.scene.greatest_rates import GreatestRates


@pytest.mark.parametrize("machine", ["c180", "forwarder"])
def test_of_joints_slowed_by_the_limit_rate_one_alone_goes_as_fast_as_it_may(machine):
    crane = load_machine(machine)
    p, greatest = parameters(crane, Settings()), GreatestRates(crane)
    low, high = np.array(joint_limits(crane)).T
    draw, found = np.random.default_rng(7), set()
    for _ in range(400):
        q = tuple(draw.uniform(0.8 * low + 0.2 * high, 0.2 * low + 0.8 * high).tolist())
        if is_singular(q, p.links):
            continue
        asked = joint_rates(q, tuple(draw.uniform(-1.5, 1.5, 3).tolist()), p.links)
        scaling = velocity_scaling(q, asked, velocity_limits_at(q, asked, p))
        if scaling.limit != Limit.RATE:
            continue
        rates = [scaling.factor * rate for rate in asked]
        joints = {f"{axis}.position": angle for axis, angle in zip(AXES, q, strict=True)}
        joints |= {f"{axis}.velocity": rate for axis, rate in zip(AXES, rates, strict=True)}
        told = greatest.signals(joints)
        shares = [
            abs(rate) / told[f"crane/{axis}.greatest_rate"] for axis, rate in zip(AXES, rates, strict=True)
        ]
        assert max(shares) == pytest.approx(1.0)
        found.add(AXES[int(np.argmax(shares))])
    assert found >= {"boom", "stick"}


def test_without_the_joints_nobody_knows():
    told = GreatestRates(load_machine("c180")).signals({"swing.position": 0.0})
    assert list(told) == [f"crane/{axis}.greatest_rate" for axis in AXES]
    assert all(map(math.isnan, told.values()))
