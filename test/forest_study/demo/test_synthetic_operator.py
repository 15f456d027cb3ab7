"""The hand that never was moves as hands do, within a lever's range, and is the same for the same seed."""

import numpy as np

from forest_control.operator.joystick_sources import read_levers
from forest_sim.simulation.voltage_profiles import read_voltages
from forest_study.demo import synthetic_operator


def test_the_same_seed_is_the_same_hand():
    assert (synthetic_operator.hand_levers(3, 5.0)[1] == synthetic_operator.hand_levers(3, 5.0)[1]).all()
    assert (synthetic_operator.hand_levers(3, 5.0)[1] != synthetic_operator.hand_levers(4, 5.0)[1]).any()


def test_levers_begin_and_end_centred_stay_in_range_and_never_jump():
    for seed in range(20):
        times, levers = synthetic_operator.hand_levers(seed, 6.0)
        assert not levers[times <= synthetic_operator.AT_REST[0]].any()
        assert not levers[-1].any()
        assert 0.1 < np.abs(levers).max() <= 1.0
        fastest = (
            1.875 * 2.0 * synthetic_operator.REACH / synthetic_operator.MOVEMENT[0] / synthetic_operator.RATE
        )  # of minimum jerk, peak over mean
        assert (
            np.abs(np.diff(levers, axis=0)).max()
            < fastest + 2.0 * synthetic_operator.TREMOR + 1.0 / synthetic_operator.STEPS
        )


def test_files_are_read_by_the_joystick_and_by_the_commander(tmp_path):
    synthetic_operator.write_csv(
        tmp_path / "levers.csv", synthetic_operator.HEADER, *synthetic_operator.hand_levers(1, 3.0)
    )
    assert read_levers(tmp_path / "levers.csv").times[-1] == 3.0
    times, ramps = synthetic_operator.valve_ramps(2.5, 0.5)
    synthetic_operator.write_csv(tmp_path / "volts.csv", "time,swing,boom,stick", times, ramps)
    assert read_voltages(tmp_path / "volts.csv").duration == 6.0
    assert (np.abs(ramps) > 0.0).sum(axis=1).max() == 1  # one valve at a time
    assert ramps.max(axis=0).tolist() == [2.5] * 3
    assert ramps.min(axis=0).tolist() == [-2.5] * 3
