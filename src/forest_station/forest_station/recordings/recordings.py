"""The bags of a station: their directory, the recorder, and the process that reads them."""

from pathlib import Path

from forest_description.machine import Machine
from forest_station.recordings.bag_directory import BagDirectory
from forest_station.recordings.recorder_process import RecorderProcess
from forest_station.recordings.replay_worker import ReplayWorker


class Recordings:
    """What the server asks.

    Args:
        directory: of the bags.
        namespace: of the crane, "/" or "/name".
        machine: of the crane.
    """

    def __init__(self, directory: Path, namespace: str, machine: Machine) -> None:
        self.bags = BagDirectory(directory)
        self.recorder = RecorderProcess(self.bags, namespace)
        self.replays = ReplayWorker(machine)

    async def close(self) -> None:
        """End the recording and the reading process."""
        self.replays.close()
        await self.recorder.close()
