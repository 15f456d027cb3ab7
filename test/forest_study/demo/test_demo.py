"""The demo, whole: what it leaves is read by programs that nobody here wrote."""

import json
import os
import subprocess
import sys

import numpy as np
import pytest

NODES = {"joystick", "controller", "valve_driver", "simulator", "recorder"}
PICTURES = {"tip_path.png", "tip_error.png", "joints.png", "voltages.png", "hydraulics.png"}


def demo(*options, environment=None):
    command = [sys.executable, "-m", "forest_study.demo.demo", *options]
    environment = {**os.environ, **(environment or {})}
    return subprocess.run(command, capture_output=True, text=True, timeout=300, env=environment, check=False)


@pytest.fixture(scope="module")
def session(tmp_path_factory, session_domain_id):
    """A three-second session in a domain of its own."""
    out = tmp_path_factory.mktemp("demo") / "out"
    done = demo("--out", str(out), "--duration", "3", environment={"ROS_DOMAIN_ID": str(session_domain_id)})
    assert done.returncode == 0, done.stdout + done.stderr
    return out, done.stdout, json.loads((out / "summary.json").read_text())


@pytest.fixture(scope="module")
def driven(session):
    """The session's bag, if nobody was silent for so long that the controller had to let go of the crane."""
    from forest_bag.read.timeseries import read_bag
    from forest_msgs_py.interfaces import topics

    bag = read_bag(session[0] / "bag")
    heard = (topics.JOY, topics.JOINT_STATES, topics.VALVE_COMMANDS)
    silence = max(np.diff(bag.series(topic).log_time_ns).max() for topic in heard) * 1e-9
    if silence > 0.1:
        pytest.skip(f"this machine was so busy that a node was silent for {silence:.2f} s")
    return bag


def test_summary_tells_the_session(session):
    _, _, summary = session
    assert summary["duration_s"] == 3.0
    assert summary["scheme"] == "coordinated"
    assert summary["lost_messages"] == 0
    assert summary["exit_codes"] == dict.fromkeys(NODES, 0)
    for name in ("governed", "cross_track", "wish"):
        assert 0.0 < summary["tip_error_mm"][name]["rms"] <= summary["tip_error_mm"][name]["max"]
    assert 0.0 < summary["joy_to_valve_ms"]["p50"] <= summary["joy_to_valve_ms"]["p99"]
    felt = summary["lever_to_valve_ms"]["first"]
    assert 8.0 < felt["p50"] <= felt["p99"]  # read one of the joystick's periods of 10 ms behind
    left_out = max(0, summary["missed_deadlines"] - 20)  # that much the machine makes up for
    assert summary["topics"]["/joint_states"]["count"] > 500 - left_out
    assert all({"count", "rate_hz"} <= set(topic) for topic in summary["topics"].values())
    assert set(summary["peak_memory_mb"]) == NODES
    assert max(summary["peak_memory_mb"].values()) < 75.0


def test_progress_table_and_paths_are_printed(session):
    out, text, _ = session
    assert "driving" in text
    assert "mm RMS" in text
    assert str(out / "summary.json") in text


def test_every_picture_is_a_png_of_readable_width(session):
    out, _, _ = session
    assert {path.name for path in out.glob("*.png")} == PICTURES
    for path in out.glob("*.png"):
        data = path.read_bytes()
        assert data.startswith(b"\x89PNG")
        assert int.from_bytes(data[16:20], "big") >= 900


def test_no_node_complained(session):
    out, _, _ = session
    logs = "".join(path.read_text() for path in (out / "log").iterdir())
    assert "ERROR" not in logs
    assert "Traceback" not in logs


def test_rosbags_reads_the_bag(session):
    from rosbags.highlevel import AnyReader

    out, _, summary = session
    with AnyReader([out / "bag"]) as reader:
        counts = {c.topic: c.msgcount for c in reader.connections}
        assert counts["/joint_states"] == summary["topics"]["/joint_states"]["count"]
        chosen = [c for c in reader.connections if c.topic == "/joint_states"]
        names = [reader.deserialize(raw, c.msgtype).name for c, _, raw in reader.messages(chosen)]
    assert len(names) == counts["/joint_states"]
    assert all(name == ["swing", "boom", "stick"] for name in names)


def test_mcap_ros2_support_reads_the_bag(session):
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    out, _, summary = session
    (file,) = (out / "bag").glob("*.mcap")
    with file.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        voltages = [message for _, _, _, message in reader.iter_decoded_messages(topics=["/valve_voltages"])]
    assert len(voltages) == summary["topics"]["/valve_voltages"]["count"]
    assert voltages[0].layout.dim[0].label == "swing,boom,stick"
    assert list(voltages[-1].data[2:]) == [0.0, 0.0, 0.0]


def test_the_crane_moved_where_it_was_wished(driven):
    from forest_msgs_py.interfaces import topics

    assert abs(driven.series(topics.VALVE_VOLTAGES).values).max() > 1.0
    tip = driven.series(topics.GROUND_TRUTH_TIP_POSE).values[:, :3]
    assert tip[0] == pytest.approx([5.5, 0.0, 1.0], abs=1e-6)
    assert 0.2 < tip[-1][0] - tip[0][0] < 0.8  # 0.3 m/s from 1 s on, less the scheme's lag


@pytest.fixture
def forked(start_process, domain_id):
    """A demo that is over, forked where a new one tells nothing more."""

    def run(*options):
        one = start_process(["-m", "forest_study.demo.demo", *options])
        one.ended()
        return one

    return run


def test_an_out_directory_that_exists_is_refused(tmp_path, forked):
    out = tmp_path / "out"
    out.mkdir()
    done = forked("--out", str(out))
    assert done.returncode == 1
    assert done.text().strip() == f"demo: {out} exists already; choose another --out or remove it"


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (["--duration", "-3"], "0.5 .. 86400"),
        (["--scheme", "magic"], "jacobian_position"),
        (["--joystick", "nowhere.csv"], "nowhere.csv"),
        (["--namespace", "1crane"], "1crane"),
    ],
)
def test_bad_options_name_what_is_allowed(options, named, tmp_path, forked):
    done = forked("--out", str(tmp_path / "out"), *options)
    assert done.returncode == 2
    assert named in done.text()
    assert not (tmp_path / "out").exists()


STOPPED = """
import sys
from forest_bringup.supervisor import Stopped
from forest_study.demo import demo

def stopped(options):
    if {recorded}:
        (options.out / demo.BAG).mkdir(parents=True)
    raise Stopped

demo._demo = stopped
sys.exit(demo.main(["--out", "out"]))
"""


@pytest.mark.parametrize("recorded", [True, False])
def test_one_that_is_stopped_says_where_the_record_is_if_there_is_one(recorded, tmp_path):
    command = [sys.executable, "-c", STOPPED.format(recorded=recorded)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, cwd=tmp_path, check=False)
    assert done.returncode == 130
    assert ("what was recorded is in out" in done.stderr) == recorded
    assert "stopped before the session's end" in done.stderr


def test_a_bad_lever_file_is_refused_before_anything_starts(tmp_path, forked):
    levers = tmp_path / "levers.csv"
    levers.write_text("time_s,swing,boom,stick\n0,0,0,0\n1,0,7,0\n")
    done = forked("--out", str(tmp_path / "out"), "--joystick", str(levers))
    assert done.returncode == 1
    assert f"{levers}:3: boom is '7'; allowed: -1 .. 1" in done.text()
    assert not (tmp_path / "out").exists()


def test_levers_from_a_file_drive_the_joints(tmp_path, forked):
    levers = tmp_path / "levers.csv"
    levers.write_text("time_s,swing,boom,stick\n0,0,0,0\n0.2,0.5,0,0\n1.2,0,0,0\n1.5,0,0,0\n")
    out = tmp_path / "out"
    done = forked("--out", str(out), "--joystick", str(levers), "--scheme", "joint")
    assert done.returncode == 0, done.text()
    summary = json.loads((out / "summary.json").read_text())
    assert summary["tip_error_mm"] is None
    assert summary["duration_s"] == 1.5
