"""Fuzzes one reader, guided by the lines that it runs: `scripts/fuzz.sh`.

    python test/fuzz/fuzz.py                                      prints the targets
    python test/fuzz/fuzz.py TARGET FOLDER [options of libFuzzer] keeps what runs new lines in the folder

An input that takes over 1 s of processor or 1 GB, or raises what no reader may, ends the run and is kept.
"""

import sys
from pathlib import Path

import atheris

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "helpers"))
FOREST = ("bag", "control", "description", "ident", "msgs_py", "sim", "station", "study")
with atheris.instrument_imports(include=[f"forest_{package}" for package in FOREST]):
    import fuzz_targets as targets

LIMITS = "-timeout=60", "-rss_limit_mb=1024"  # a hang ends by the clock; a second of processor in `run`


def main() -> None:
    """Run libFuzzer, beginning with seeds and corpus."""
    name, folder = sys.argv[1:3]
    for number, seed in enumerate([*targets.TARGETS[name].seeds(), *targets.corpus(name)]):
        (Path(folder) / f"seed-{number}").write_bytes(seed)
    targets.warm(name)
    atheris.Setup([sys.argv[0], folder, *LIMITS, *sys.argv[3:]], lambda data: targets.run(name, data))
    atheris.Fuzz()


if __name__ == "__main__":
    if len(sys.argv) > 1:
        main()
    else:
        print("\n".join(targets.TARGETS))
