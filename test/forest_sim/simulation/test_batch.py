"""Many runs over all cores are the serial ones, in order."""

from dataclasses import replace

import numpy as np
import pytest

from forest_description.derived.limits import joint_limits
from forest_description.machine import load_machine
from forest_sim.simulation import voltage_profiles
from forest_sim.simulation.batch import Job, simulate_many, simulate_one
from forest_sim.simulation.open_loop import Run, RunError
from forest_sim.solver.state_recording import STATE

C180 = load_machine("c180_hoses")
RUN = Run(0.5, 100.0)


def last_swing_angle(run):
    return float(run.states[-1, STATE.index("swing_angle")])


def jobs(count):
    generator = np.random.default_rng(3)
    draws = generator.uniform(0.5, 1.5, count).tolist()
    manipulator = C180.manipulator
    machines = [
        replace(C180, manipulator=replace(manipulator, head_mass=manipulator.head_mass * draw))
        for draw in draws
    ]
    return [Job(machine, voltage_profiles.chirp(8.0, 1.0, 4.0, 3.0)) for machine in machines]


def test_parallel_runs_are_the_serial_ones_in_order():
    given = jobs(5)
    serial = [simulate_one(job, RUN, lambda run: run) for job in given]
    together = simulate_many(given, RUN, workers=2)
    for one, other in zip(serial, together, strict=True):
        for a, b in zip(one, other, strict=True):
            np.testing.assert_array_equal(a, b)
    assert len({last_swing_angle(run) for run in together}) == 5


def test_one_worker_needs_no_process_and_keeps_what_is_asked():
    kept = simulate_many(jobs(2), RUN, lambda run: last_swing_angle(run), workers=1)
    assert kept == [last_swing_angle(simulate_one(job, RUN, lambda run: run)) for job in jobs(2)]


def test_a_job_that_cannot_be_is_told():
    beyond = jobs(1)[0]._replace(angles=(0.0, 2.0, -1.5))
    with pytest.raises(RunError, match=r"boom at 114.6 deg, allowed there: -36.7 .. 72.0 deg"):
        simulate_many([beyond], RUN)


def test_a_job_without_a_pose_starts_where_its_machine_can_be():
    short = replace(C180, manipulator=replace(C180.manipulator, boom_length=1.0))
    kept = simulate_many([jobs(1)[0]._replace(machine=short, angles=None)], RUN)
    assert kept[0].states[0, STATE.index("boom_angle")] == pytest.approx(sum(joint_limits(short)[1]) / 2)
