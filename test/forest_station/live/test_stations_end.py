"""What becomes of a crane whose station freezes or dies: the last tests of the folder."""

import os
import signal

import pytest
from stall import Stall
from stand_in_page import driving, play

SHUTS_S, WATCH_S = 0.25, 0.15


@pytest.mark.parametrize("number", [signal.SIGSTOP, signal.SIGKILL], ids=["frozen", "killed"])
def test_a_station_that_dies_or_freezes_stops_the_crane_by_the_controllers_watch(crane, number):
    async def scenario():
        async with driving(crane):
            stall = Stall(*(pid for name, pid in crane.pids.items() if name != "station"))
            os.kill(crane.pids["station"], number)
            try:
                await crane.ears.still()
                stop, lost = crane.ears.stop(), stall.seconds()
                assert stop.shut - stop.heartbeat < WATCH_S + SHUTS_S + lost
            finally:
                crane.ears.forget()
                if number == signal.SIGSTOP:
                    os.kill(crane.pids["station"], signal.SIGCONT)
            if number == signal.SIGSTOP:
                await crane.ears.until(lambda: len(crane.ears.joy) > 50)
                assert not any(joy.held for joy in crane.ears.joy)

    play(scenario())
