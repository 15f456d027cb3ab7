"""Claims about a device's joystick as a process: driven, unplugged, plugged in again, hung, stopped."""

import os

import pytest
from input_events import held_file, stream

pytest.importorskip("rclpy")

from forest_control.operator.levers import LEFT_SHOULDER, LEFT_X
from forest_msgs_py.interfaces import topics
from forest_msgs_py.interfaces.messages import read_joy, stamp_to_ns


class Cable:
    """A named pipe that is there while it is plugged in."""

    def __init__(self, path):
        self.path, self.ends = path, ()

    def plug(self):
        making = self.path.with_suffix(".making")
        os.mkfifo(making)
        reader = os.open(making, os.O_RDONLY | os.O_NONBLOCK)  # what nobody reads cannot be written to
        self.ends = reader, os.open(making, os.O_WRONLY)
        making.rename(self.path)

    def report(self, *reports):
        os.write(self.ends[1], stream(*reports))

    def unplug(self):
        self.path.unlink()
        for end in self.ends:
            os.close(end)


@pytest.fixture
def cable(tmp_path):
    cable = Cable(tmp_path / "device")
    cable.plug()
    yield cable
    cable.unplug()


def start(start_process, cable, *arguments):
    return start_process(["-m", "piped_joystick_node", str(cable.path), *arguments])


def swing(message):
    reading = read_joy(message, 6, LEFT_SHOULDER + 1)
    assert reading.problem == ""
    return reading.values.axes[LEFT_X]


def moves(heard, swung):
    return bool(heard) and swing(heard[-1]) == swung and heard[-1].buttons[LEFT_SHOULDER] == 1


def at_rest(message):
    return not any(message.axes) and not any(message.buttons)


def test_a_device_drives_joy_and_unplugged_rests_it_then_silences_it_until_released_again(
    peer, start_process, cable
):
    heard = peer.hear(topics.JOY)
    process = start(start_process, cable, "--device")
    peer.until(lambda: heard)
    assert at_rest(heard[-1])
    cable.report({"BTN_TL": 1}, {"ABS_X": 0})
    peer.until(lambda: moves(heard, 1.0))
    assert heard[-1].header.frame_id == "joy"
    cable.unplug()
    peer.until(lambda: at_rest(heard[-1]))
    peer.until(lambda: "no device fits gamepad" in process.text())
    count = len(heard)
    held_file(cable.path).touch()
    cable.plug()
    peer.until(lambda: len(heard) > count)
    said = stamp_to_ns(heard[count].header.stamp) - stamp_to_ns(heard[count - 1].header.stamp)
    assert said > 0.1e9  # silent meanwhile
    peer.until(lambda: "release the deadman" in process.text())
    peer.until(lambda: len(heard) > count + 5)
    assert all(map(at_rest, heard[count:]))
    cable.report({"BTN_TL": 0, "ABS_X": 128})
    peer.until(lambda: process.text().count("joystick: gamepad: Pad") > 1)
    cable.report({"BTN_TL": 1}, {"ABS_X": 255})
    peer.until(lambda: moves(heard, -1.0))
    assert process.stop() == 0
    peer.until(lambda: at_rest(heard[-1]))
    assert "Traceback" not in process.text()


def test_a_driver_that_hangs_ends_in_silence(peer, start_process, cable):
    heard = peer.hear(topics.JOY)
    process = start(start_process, cable, "--device", "--ros-args", "-p", "frozen_timeout:=0.5")
    peer.until(lambda: heard)
    cable.report({"BTN_TL": 1}, {"ABS_X": 0})
    peer.until(lambda: moves(heard, 1.0))
    peer.until(lambda: "device gamepad is still for too long" in process.text())
    peer.until(lambda: at_rest(heard[-1]))
    assert process.stop() == 0


def test_what_is_not_allowed_ends_the_node_with_one_line(domain_id, start_node, tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("devices: {}")
    refused = {
        f"device:={file}": "devices is {}; allowed: a mapping of one device or more",
        "frozen_timeout:=0.0": "parameter 'frozen_timeout' is 0.0; allowed: 0.5 .. 60 s",
    }
    processes = {said: start_node("joystick_node", "-p", given) for given, said in refused.items()}
    lockstep = start_node("joystick_node", "-p", "device:=auto", "-p", "lockstep:=true")
    processes["parameter 'device': a hand moves in real time"] = lockstep
    for said, process in processes.items():
        assert process.ended() == 2
        assert process.text().count("\n") == 1
        assert said in process.text()
