"""The golden record: runs that repeat to the last bit, and a hash of everything that they leave.

Only commands are run, as a user would type them, and bags are read by a library that is not ours.
So a hash stays the same when modules move. A line is `SHA-256 count RUN/FILE[:topic]`.

Left out, because they tell of the maker or of the wall clock:
- of bags: `metadata.yaml`, attachments, metadata records, `/rosout` (it names source files);
- logs, pictures and pages;
- in JSON, the keys of `LEFT_OUT`.

Not covered: an emergency stop in mid-run. It comes from outside the lockstep, so its step is not repeatable.
"""

import argparse
import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from mcap.reader import make_reader

ROOT = Path(__file__).resolve().parents[1]
BIN = Path(sys.executable).parent
SCHEMES = ("joint", "ik_velocity", "ik_position", "jacobian_velocity", "jacobian_position", "coordinated")
DRIVE = (str(ROOT / "scripts/demo.sh"), "--lockstep", "--duration", "6")
LEFT_OUT = {  # key in a JSON file: why
    "peak_memory_mb": "of the processes",
    "/rosout": "how much is logged goes by the wall clock",
    "joy_to_valve_ms": "a delay by the wall clock",
    "missed_deadlines": "by the wall clock",
    "seconds": "how long the computation took",
}
WALLS = "ground: -0.5\nboxes:\n  - {lower: [6.1, -1, 0], upper: [7, 1, 3]}\nmargin: 0.1\napproach: 2.0\n"


def _replayed(*changes: str) -> tuple[str, ...]:
    """Return the command that repeats the run `scheme_coordinated` with changed parameters."""
    bag = ("replay", "scheme_coordinated/bag", "--nodes", "simulator")
    return ("forest-study", *bag, "--set", *changes, "--out", "{out}")


RUNS: dict[str, tuple[str, ...]] = {
    **{f"scheme_{name}": (*DRIVE, "--scheme", name, "--out", "{out}") for name in SCHEMES},
    "loader": (*DRIVE, "--machine", "loader", "--out", "{out}"),
    "joystick_faults": (
        *(*DRIVE, "--joystick-faults", "lost from 2 s until 2.6 s; frozen from 4 s until 5 s"),
        *("--out", "{out}"),
    ),
    "noise": _replayed("simulator.sensor_noise=true"),
    "adapt": _replayed("simulator.sensor_noise=true", "valve_driver.adapt=true"),
    "walls": _replayed("controller.workspace=wall_file.yaml"),
    "track": ("forest-study", "track", "--path", "all", "--noise", "--seeds", "2", "--out", "{out}"),
    "track_adapt": (
        *("forest-study", "track", "--path", "circle_h", "--mismatch", "--adapt", "--laps", "2"),
        *("--noise", "--out", "{out}"),
    ),
    "track_position": (
        *("forest-study", "track", "--path", "sweep", "--scheme", "jacobian_position", "--out", "{out}"),
    ),
    "delay": ("forest-study", "delay", "--out", "{out}"),
    "thesis": ("forest-study", "thesis", "--out", "{out}"),
    "thesis_machine": ("forest-study", "thesis", "--plant", "machine", "--out", "{out}"),
    "experiment": ("forest-ident", "experiment", "spool_lag", "--seed", "3", "--out", "{out}"),
    "valve": ("forest-ident", "experiment", "valve", "--direct", "--out", "{out}"),
    "fit": ("forest-ident", "fit", "valve", "--out", "{out}.yaml"),
    "held_out": ("forest-ident", "experiment", "validation", "--direct", "--out", "{out}"),
    "validation": (
        *("forest-ident", "validate", "held_out/validation", "--model", "fit.yaml"),
        *("--report", "{out}"),
    ),
}
COMPARES = {"noise", "adapt", "walls"}  # replays, which answer 1: something differs, and shall


def main() -> int:
    """Make the runs and print the list; return the exit code."""
    parser = argparse.ArgumentParser(prog="scripts/golden.sh", description=__doc__)
    parser.add_argument("runs", nargs="*", metavar="RUN", help=f"of {', '.join(RUNS)}; default: all, in turn")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep what the runs leave; to be made")
    options = parser.parse_args()
    if unknown := sorted(set(options.runs) - set(RUNS)):
        parser.error(f"no run {', '.join(unknown)}; allowed: {', '.join(RUNS)}")
    with tempfile.TemporaryDirectory(prefix="forest-golden-") as scratch:
        place = options.keep or Path(scratch)
        place.mkdir(parents=True, exist_ok=True)
        (place / "wall_file.yaml").write_text(WALLS, encoding="utf-8")
        for name in options.runs or RUNS:
            print(name, file=sys.stderr, flush=True)
            if failure := _run(name, place):
                print(f"golden: {name} failed: {failure}", file=sys.stderr)
                return 1
            for line in _list(place, name):
                print(line, flush=True)
    return 0


def _run(name: str, place: Path) -> str:
    """Make a run; return why it failed, "" if it did not."""
    words = [word.replace("{out}", name) for word in RUNS[name]]
    words[0] = words[0] if Path(words[0]).is_absolute() else str(BIN / words[0])
    environment = os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "OMP_NUM_THREADS": "1"}
    done = subprocess.run(words, cwd=place, env=environment, capture_output=True, text=True, check=False)
    allowed = (0, 1) if name in COMPARES else (0,)
    return "" if done.returncode in allowed else f"exit code {done.returncode}: {done.stderr.strip()[-400:]}"


def _list(place: Path, name: str) -> Iterator[str]:
    """Yield the lines of a run: its directory and the files that begin with its name."""
    files = sorted({*place.glob(f"{name}.*"), *(place / name).rglob("*")})
    for path in files:
        hashed = HASHED.get(path.suffix)
        if hashed and path.name != "metadata.yaml" and "log" not in path.parts:
            yield from hashed(path, str(path.relative_to(place)))


def _bag(path: Path, label: str) -> Iterator[str]:
    """Yield a line per topic: its type, times and bytes."""
    digests: dict[str, Any] = {}
    counts: dict[str, int] = {}
    with path.open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages():
            topic, times = channel.topic, f"{message.log_time} {message.publish_time} "
            digest = digests.setdefault(topic, hashlib.sha256(str(schema and schema.name).encode()))
            digest.update(times.encode() + message.data)
            counts[topic] = counts.get(topic, 0) + 1
    for topic in sorted(set(digests) - {"/rosout"}):
        yield f"{digests[topic].hexdigest()} {counts[topic]} {label}:{topic}"


def _json(path: Path, label: str) -> Iterator[str]:
    """Yield one line: of the content but for what is left out."""
    told = json.dumps(_without(json.loads(path.read_text(encoding="utf-8"))), sort_keys=True)
    yield f"{hashlib.sha256(told.encode()).hexdigest()} {len(told)} {label}"


def _without(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without(item) for key, item in value.items() if key not in LEFT_OUT}
    return [_without(item) for item in value] if isinstance(value, list) else value


def _whole(path: Path, label: str) -> Iterator[str]:
    """Yield one line: of a file as it is."""
    data = path.read_bytes()
    yield f"{hashlib.sha256(data).hexdigest()} {len(data)} {label}"


HASHED: dict[str, Callable[[Path, str], Iterator[str]]] = {
    ".mcap": _bag,
    ".json": _json,
    ".yaml": _whole,
    ".csv": _whole,
}

if __name__ == "__main__":
    sys.exit(main())
