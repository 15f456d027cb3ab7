"""Bags are read beside the station's loop: it goes on, whatever a bag does to the process that reads it."""

import asyncio
import os
import signal
from pathlib import Path

import pytest

from forest_bag.storage.bag_files import BagError
from forest_description.machine import load_machine
from forest_station.recordings import replay_worker
from forest_station.recordings.replay_bag import ReplayBag
from forest_station.recordings.replay_frames import frames, window
from forest_station.recordings.replay_worker import MOST_MEMORY, MOST_OPEN, NICE, ReplayWorker, _OpenBags

BAG = Path("bags/coordinated").absolute()
MEMORY_MB = 200.0


def asked(action):
    """What an action of a worker's returns."""

    async def run():
        worker = ReplayWorker(load_machine("c180_hoses"))
        try:
            return await action(worker)
        finally:
            worker.close()

    return asyncio.run(run())


def of_process(pid, key):
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith(f"{key}:"):
            return float(line.split()[1])
    raise AssertionError(key)


def test_the_process_answers_as_the_room_does_nicely_and_in_little_memory():
    async def action(worker):
        told = await worker.describe(BAG)
        data = await worker.frames(BAG, 0.0, 5.0, 30.0)
        pid = worker._process.pid
        return told, data, of_process(pid, "VmHWM") / 1024, os.getpriority(os.PRIO_PROCESS, pid)

    told, data, memory, nice = asked(action)
    bag = ReplayBag(BAG, load_machine("c180_hoses"))
    assert told["signals"] == list(bag.units.items())
    assert data == frames(bag, window(0.0, 5.0, 30.0))
    assert memory < MEMORY_MB
    assert nice == min(19, os.getpriority(os.PRIO_PROCESS, 0) + NICE)
    assert MOST_MEMORY == 1 << 30


def test_the_loop_goes_on_while_a_bag_is_read():
    """The process is stopped: had the loop read the pipe itself, it would hang with it."""

    async def action(worker):
        await worker.describe(BAG)
        pid = worker._process.pid
        os.kill(pid, signal.SIGSTOP)
        waiting = asyncio.ensure_future(worker.frames(BAG, 0.0, 1.0, 30.0))
        for _ in range(100):
            await asyncio.sleep(0)
        assert not waiting.done()
        os.kill(pid, signal.SIGCONT)
        return await waiting

    assert len(asked(action)) > 0


def test_a_process_that_died_or_hangs_is_told_and_the_next_bag_is_read():
    async def action(worker):
        await worker.describe(BAG)
        worker._process.kill()
        worker._process.wait()
        with pytest.raises(BagError, match="coordinated is not shown"):
            await worker.describe(BAG)
        await worker.describe(BAG)
        os.kill(worker._process.pid, signal.SIGSTOP)
        worker._longest_answer = 0.01
        with pytest.raises(BagError, match=r"took longer than 0\.01 s: coordinated is not shown"):
            await worker.describe(BAG)
        worker._longest_answer = replay_worker.LONGEST_ANSWER_S
        return await worker.describe(BAG)

    assert asked(action)["seconds"] == 5.3


def test_what_is_wrong_with_a_question_is_the_answer(tmp_path):
    bags = _OpenBags(load_machine("c180_hoses"))
    assert "allowed" in str(bags.answer("frames", str(BAG), 0.0, 1.0, -1.0))
    assert "cannot be read" in str(bags.answer("describe", str(tmp_path / "none.mcap")))


def test_few_bags_are_open_at_once_and_one_that_has_grown_is_opened_anew(tmp_path):
    bags = _OpenBags(load_machine("c180_hoses"))
    first = bags.get(str(BAG))
    assert bags.get(str(BAG)) is first
    for name in ("valves", "fault"):
        bags.get(str(BAG.with_name(name)))
    assert len(bags._bags) == MOST_OPEN
    assert bags.get(str(BAG)) is not first
    growing = tmp_path / "growing.mcap"
    data = (BAG / "coordinated_0.mcap").read_bytes()
    growing.write_bytes(data[:400_000])
    half = bags.get(str(growing)).seconds
    growing.write_bytes(data)
    assert bags.get(str(growing)).seconds > half
