"""A short session of the whole graph in lockstep."""

from forest_bringup import graph

LOCKSTEP_STEPS = 200
LEVERS = "time_s,swing,boom,stick\n0,0,0,0\n0.1,0.6,0.4,-0.3\n0.5,0,0.2,0.5\n0.8,0,0,0\n"


def lockstep_session(out, source):
    """Return the nodes of a whole graph, its bag in a directory; levers from a file are not faultless."""
    faults = "" if source.is_dir() else "lost from 0.4 s until 0.43 s; frozen from 0.6 s until 0.7 s"
    return [
        graph.joystick(str(source), 0.0, 0, faults),
        *graph.control("c180", "jacobian_position", shadow=False, describe=False),
        graph.simulator("c180", "400 kg from 0.3 s; 0 kg from 0.7 s"),
        graph.recorder(out / "bag"),
    ]
