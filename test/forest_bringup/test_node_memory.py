"""The memory of a node that the summary tells: its own, and the most that was seen."""

import subprocess
import sys

import pytest

from forest_bringup.supervisor import NodeSpec, Supervisor, _Process

MB = 2**20
# Holds memory of its own, or pages of a file, as the lines on its input say, and answers when it has.
NODE = """
import mmap, sys
file = open(sys.argv[1], "rb")
pages = mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
for line in sys.stdin:
    kind, size = line.split()
    if kind == "own":
        held = bytearray(b"x") * int(size)
    else:
        assert not any(pages[k] for k in range(0, int(size), 4096))
    print("done", flush=True)
"""


@pytest.fixture
def node(tmp_path):
    """A process that holds what `hold(kind, MB)` says; give both."""
    library = tmp_path / "library"
    with library.open("wb") as file:
        file.truncate(60 * MB)
    command = [sys.executable, "-c", NODE, str(library)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as popen:

        def hold(kind, megabytes):
            popen.stdin.write(f"{kind} {megabytes * MB}\n".encode())
            popen.stdin.flush()
            assert popen.stdout.readline() == b"done\n"

        hold("own", 0)
        with library.open() as log:
            yield _Process(NodeSpec("node", "module"), popen, library, log), hold


def test_a_nodes_memory_is_its_own_and_the_most_that_was_seen(node, tmp_path):
    process, hold = node
    graph = Supervisor([], "/", tmp_path)

    def noted():
        graph._record_memory(process)
        return graph.peak_memory_mb["node"]

    idle = noted()
    assert 0.0 < idle < 40.0
    hold("file", 60)
    assert noted() == pytest.approx(idle, abs=5.0)
    hold("own", 50)
    held = noted()
    assert held == pytest.approx(idle + 50.0, abs=5.0)
    hold("own", 0)
    assert noted() == held
