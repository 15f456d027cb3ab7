"""Numbers of the summary against hand-made cases."""

import numpy as np

from forest_study.demo.session_summary import response_times, table, valve_crossings, work_per_metre

SESSION = {
    "scheme": "joint",
    "duration_s": 3.0,
    "topics": {"/joy": {"count": 7, "rate_hz": 100.0}},
    "lost_messages": 2,
    "tip_error_mm": None,
    "joy_to_valve_ms": None,
    "lever_to_valve_ms": {"first": {"p50": 16.94, "p99": 51.0}, "half_step": None, "half_way": None},
    "pump_work": {"kj": 30.0, "kj_per_m": 12.5},
    "peak_memory_mb": {"recorder": 70.4},
}


def test_response_time_counts_from_the_cause_to_the_first_effect_of_a_later_state():
    causes = np.array([100, 200, 1000])
    states, effects = np.array([90, 150, 205, 240]), np.array([99, 158, 209, 246])
    # 100 is answered by state 150 (seen at 158), 200 by 205 (seen at 209), 1000 by nothing.
    np.testing.assert_array_equal(response_times(causes, states, effects), [58, 9])


def test_a_state_sampled_at_the_very_moment_does_not_know_the_cause():
    np.testing.assert_array_equal(response_times(np.array([5]), np.array([5, 6]), np.array([7, 9])), [4])


def test_no_effect_at_all_gives_no_times():
    assert len(response_times(np.array([5]), np.array([], dtype=np.int64), np.array([], dtype=np.int64))) == 0


def test_no_distance_of_the_tip_is_told_alone():
    off = {"rms": 3.31, "max": 9.8}
    errors = {"governed": off, "cross_track": {"rms": 6.5, "max": 20.2}, "wish": None, "time_lost_s": 0.25}
    rows = [line.split(maxsplit=3) for line in table({**SESSION, "tip_error_mm": errors}).splitlines()]
    told = {" ".join(row[:3]): row[3] for row in rows if row[0] in ("tip", "time")}
    assert told["tip to reference"] == "3.31 mm RMS, 9.8 mm max"
    assert "tip to drawn" in told
    assert told["tip to wish"] == "- (no lever asked)"
    assert told["time lost 0.25"] == "s"


def test_the_pump_s_work_is_told_per_metre_of_the_tip():
    time, places = np.array([0.0, 1.0, 3.0]), np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [3.0, 4.0, 0.0]])
    assert work_per_metre(time, np.array([0.0, 2e4, 2e4]), places) == {"kj": 50.0, "kj_per_m": 7.1}
    assert work_per_metre(time, np.array([1e3, 1e3, 1e3]), places[:1]) == {"kj": 3.0, "kj_per_m": 0.0}
    assert "pump work          12.5 kJ per metre" in table(SESSION)


def test_a_valve_crosses_when_its_voltage_comes_back_from_zero_on_the_other_side():
    swing, boom, stick = [0.0, 1.2, 1.4, 0.0, -1.1], [1.1, 0.0, 1.1, 0.0, 1.2], [2.0, -2.0, 2.0, 0.0, 0.0]
    voltages = np.array([swing, boom, stick]).T
    assert valve_crossings(voltages) == {"swing": 1, "boom": 0, "stick": 2}


def test_table_says_that_joint_mode_has_no_tip_error():
    text = table(SESSION)
    assert "7, lost 2" in text
    assert "joint mode" in text
    assert "lever to valve     16.9 ms median, 51.0 ms p99" in text
    assert "half" not in text
    assert "recorder 70 MB" in text
