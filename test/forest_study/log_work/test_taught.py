"""The task as a taught cycle: the planner takes it, and it passes where the task does."""

import pytest

from forest_control.config import controller_settings
from forest_control.taught.cycle import Grapple, Path
from forest_control.taught.cycle_file import load_cycle, save_cycle
from forest_control.taught.plan import planned
from forest_description.machine import load_machine
from forest_study.log_work.crane import settings_of
from forest_study.log_work.site import site_of
from forest_study.log_work.taught import NAME, cycle_of


@pytest.mark.parametrize("name", ["forwarder", "loader"])
def test_the_task_is_a_cycle_that_the_planner_takes(tmp_path, name):
    machine = load_machine(name)
    site = site_of(machine)
    save_cycle(cycle_of(site), tmp_path)
    cycle = load_cycle(NAME, tmp_path)
    paths = [one for one in cycle.segments if isinstance(one, Path)]
    assert [one.action for one in cycle.segments if isinstance(one, Grapple)] == ["close", "open"] * 4
    x, y, z = site.places["red on the ground"]
    assert paths[0].points[0] == pytest.approx((x, y, z + site.hang), abs=1e-3)
    assert paths[-1].points[-1][:2] == pytest.approx(site.places["blue on the ground"][:2], abs=1e-3)
    steps = planned(
        cycle, (x, y, z + site.hang), controller_settings.parameters(machine, settings_of(machine, "taught"))
    )
    legs = [step for step in steps if hasattr(step, "path")]
    assert len(legs) == 7
    assert all(len(leg.path.stops) == 2 for leg in legs)  # corners are round: no stop on the way
