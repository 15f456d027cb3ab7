"""The processes of a graph, seen from outside."""

import os
from pathlib import Path

NODES = ("joystick", "controller", "valve_driver", "simulator", "recorder")
ALL = (*NODES, "experiment_operator", "station")


def nodes_of(supervisor):
    """Return {node name: pid} of a supervisor's children."""
    children = {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            kept, rest = (entry / "stat").read_text().rsplit(")", 1)
            command = (entry / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if int(rest.split()[1]) != supervisor.pid:
            continue
        # Whole arguments only: the fork server of `processes` names modules, too, in one long argument.
        modules = {argument.rpartition(b".")[2].decode() for argument in command}
        modules.add(kept.partition("(")[2])  # of who was forked; the kernel keeps 15 letters
        children |= {name: int(entry.name) for name in ALL if modules & {f"{name}_node", f"{name}_node"[:15]}}
    return children


def alive(pid):
    """Whether a process still runs (a zombie does not)."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


def kill(pid, number):
    os.kill(pid, number)
