"""A recording begins and ends on request, with the station and without it; no record is lost."""

import asyncio
import os
import resource
import signal

import pytest

pytest.importorskip("rclpy")

from forest_bag.read.bag_reader import BagReader
from forest_bag.storage.bag_files import BagError
from forest_station.recordings.bag_directory import BagDirectory
from forest_station.recordings.recorder_process import RecorderProcess

DIES = """
import asyncio, os, signal, sys
from forest_station.recordings.bag_directory import BagDirectory
from forest_station.recordings.recorder_process import RecorderProcess
recorder = RecorderProcess(BagDirectory(sys.argv[1]))
asyncio.run(recorder.start("left"))
print(recorder._process.pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""


def is_complete(path):
    with BagReader(path, lenient=True) as bag:
        return bag.complete


async def until(condition):
    for _ in range(6000):
        if condition():
            return
        await asyncio.sleep(0.01)
    pytest.fail("condition not met within 60 s")


@pytest.mark.usefixtures("domain_id")
def test_a_bag_is_begun_told_and_ended_and_a_killed_recorder_leaves_a_sentence_and_its_bag(tmp_path):
    async def action():
        recorder = RecorderProcess(BagDirectory(tmp_path / "bags"))
        assert not recorder.state().active
        with pytest.raises(BagError, match="nothing is recorded"):
            await recorder.stop()
        assert await recorder.start("monday") == "Recording to monday."
        with pytest.raises(BagError, match="monday is recorded already"):
            await recorder.start("tuesday")
        state = recorder.state()
        assert (state.active, state.name) == (True, "monday")
        await until(lambda: recorder.state().bytes > 0)
        assert (await recorder.stop()).startswith("recorded ")
        assert is_complete(tmp_path / "bags/monday")
        with pytest.raises(BagError, match="no bag is overwritten"):
            await recorder.start("monday")

        await recorder.start("killed")
        os.kill(recorder._process.pid, signal.SIGKILL)
        await until(lambda: not recorder.state().active)
        assert "ended by SIGKILL" in recorder.state().text
        assert "`forest-bag recover` makes it whole" in recorder.state().text

        await recorder.start()
        name = recorder.state().name
        await recorder.close()
        assert is_complete(tmp_path / "bags" / name)

    asyncio.run(action())


def test_a_recorder_ends_its_bag_when_the_station_is_killed(start_process, domain_id, wait_until, tmp_path):
    station = start_process(["-c", DIES, str(tmp_path / "bags")])
    station.ended()
    assert station.text().strip().isdecimal(), station.text()
    bag = tmp_path / "bags/left"
    wait_until(lambda: (bag / "metadata.yaml").exists(), 60.0)
    assert is_complete(bag)


@pytest.mark.usefixtures("domain_id")
def test_a_full_disk_is_told_in_a_sentence_and_the_bag_is_kept(tmp_path):
    """No file may grow beyond 4 kB, as the bag has, which the kernel refuses as it refuses a full disk."""

    async def action():
        recorder = RecorderProcess(BagDirectory(tmp_path))
        await recorder.start("full")
        await until(lambda: recorder.state().bytes > 6000)  # its own parameters are in it
        resource.prlimit(recorder._process.pid, resource.RLIMIT_FSIZE, (4096, 4096))
        return await recorder.stop()

    assert "cannot write the bag in full" in asyncio.run(action())
    assert (tmp_path / "full").is_dir()
