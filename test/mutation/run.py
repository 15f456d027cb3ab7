"""Runs the tests of a module against each of its mutants, and tells which of these nobody notices.

Works in a copy of the checkout, which scripts/mutate.sh makes. What is not the project's is imported once.
Each mutant is a fork, in which pytest runs until the first failure. llvmlite is hidden, so that laws run
interpreted: each mutant would have to be compiled anew. Those of the translator, and of what no kernel is
made of, have it.

    python run.py GENERATOR COPY [MODULE...]    interpreter with Cosmic Ray, copy, stems of modules
"""

from __future__ import annotations

import contextlib
import functools
import gc
import importlib
import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml

tomllib = importlib.import_module("tomllib" if sys.version_info >= (3, 11) else "tomli")

HERE = Path(__file__).parent
PASSED = 0
COMPILED = ("forest_compile", "forest_ident")  # packages whose tests have llvmlite
SPARE = 4.0  # times the processor time of the tests, at which a mutant that hangs is ended
WAIT = 10.0  # times their time, at which one that waits is ended, on however busy a machine
LIMIT_S = 300  # of the unbroken module's tests
Mutant = dict[str, Any]
Tests = tuple[str, ...]
Explained = dict[str, dict[str, str]]  # function, key: why


class Trial(NamedTuple):
    """What became of a test run."""

    code: int  # pytest's, or of the signal that ended it
    processor: float  # [s]
    took: float  # [s]


class Limits(NamedTuple):
    """When a test run is ended [s]."""

    processor: int
    took: int


class Row(NamedTuple):
    """A line of the table."""

    module: str
    mutants: int
    explained: int
    survived: int


@functools.cache
def layers() -> list[set[str]]:
    """Return packages from above: the tests, then as import-linter has it; nothing imports upwards."""
    project = tomllib.loads((HERE.parents[1] / "pyproject.toml").read_text("utf-8"))
    contract = project["tool"]["importlinter"]["contracts"][0]
    return [{"conftest", "test"}, *({name.strip() for name in row.split("|")} for row in contract["layers"])]


def layer(package: str) -> int:
    """Return the layer of a package."""
    return next(number for number, packages in enumerate(layers()) if package in packages)


class Quickest:
    """Has pytest run the quickest tests first: most mutants die of any."""

    def __init__(self, durations: dict[str, float]) -> None:
        self.durations = durations

    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        items.sort(key=lambda item: self.durations.get(item.nodeid, 0.0))

    def pytest_runtest_logreport(self, report: Any) -> None:
        self.durations[report.nodeid] = self.durations.get(report.nodeid, 0.0) + report.duration


def trial(tests: Tests, log: Path, quickest: Quickest, limits: Limits) -> Trial:
    """Run tests in a fork until the first failure; what they import lies beside the log, with their times."""
    begun, child = time.monotonic(), os.fork()
    if child == 0:
        os.setsid()
        output = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
        os.dup2(output, 1)
        os.dup2(output, 2)
        resource.setrlimit(resource.RLIMIT_CPU, (limits.processor, limits.processor))
        signal.alarm(limits.took)
        code = pytest.main(["-x", "-q", "-p", "no:cacheprovider", "--assert=plain", *tests], [quickest])
        log.with_suffix(".json").write_text(json.dumps([imported(), quickest.durations]))
        sys.stdout.flush()
        os._exit(code)
    _, status, used = os.wait4(child, 0)
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)
    return Trial(os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, time.monotonic() - begun)


def imported() -> list[str]:
    """Return the names of all modules but the tests' own, which may import what is to be broken."""
    own = f"{HERE.parent}/"
    return sorted(name for name, m in sys.modules.items() if own not in (getattr(m, "__file__", None) or ""))


@functools.cache
def baseline(tests: Tests, package: str, log: Path) -> tuple[Limits, Quickest]:
    """Return what a mutant may take, by the unbroken module's tests; import what cannot import the module."""
    first = trial(tests, log, Quickest({}), Limits(LIMIT_S, LIMIT_S))
    if first.code != PASSED:
        sys.exit(f"mutate: error: the tests fail without any mutant:\n{log.read_text()}")
    names, durations = json.loads(log.with_suffix(".json").read_text())
    above = set().union(*layers()[: layer(package) + 1])
    for name in names:
        if name.partition(".")[0] not in above:
            with contextlib.suppress(Exception):
                importlib.import_module(name)
    gc.collect()
    gc.freeze()
    return Limits(2 + int(SPARE * first.processor), 30 + int(WAIT * first.took)), Quickest(durations)


def is_explained(mutant: Mutant, explained: Explained) -> bool:
    """Tell whether a reason is given for the mutant itself, or for every change of its line."""
    keys = explained.get(mutant["function"], {})
    return mutant["key"] in keys or mutant["original"] in keys


def made(generator: str, *sources: Path) -> list[Mutant]:
    """Return the mutants of modules in the order of their lines."""
    command = [generator, HERE / "mutants.py", *sources]
    told = subprocess.run(command, stdout=subprocess.PIPE, check=True, text=True).stdout
    return sorted(map(json.loads, told.splitlines()), key=lambda mutant: int(mutant["line"]))


def outdated(mutants: list[Mutant], explained: Explained) -> list[str]:
    """Return what is explained but is no mutant."""
    known = {(m["function"], text) for m in mutants for text in (m["key"], m["original"])}
    return [
        f"{function}: {key}"
        for function, keys in explained.items()
        for key in keys
        if (function, key) not in known
    ]


def survivors(source: Path, mutants: list[Mutant], tests: Tests, log: Path) -> list[Mutant]:
    """Return the mutants with which the tests pass."""
    name = ".".join(source.relative_to(log.parent / "src").parts[1:]).removesuffix(".py")
    package = name.partition(".")[0]
    sys.modules.pop("llvmlite", None)
    if package not in COMPILED:
        sys.modules["llvmlite"] = None  # type: ignore[assignment]
    if package == COMPILED[0]:
        # No machine code of mutants for anybody else.
        os.environ["XDG_CACHE_HOME"] = str(log.parent / "cache")
    limits, quickest = baseline(tests, package, log)
    if name in sys.modules:
        sys.exit(f"mutate: error: {name} is imported already, so that no mutant of it would be.")
    for compiled in (source.parent / "__pycache__").glob(f"{source.stem}.*.pyc"):
        compiled.unlink()
    os.environ["PYTHONDONTWRITEBYTECODE"], sys.dont_write_bytecode = "1", True
    text, left = source.read_text("utf-8"), []
    for number, mutant in enumerate(mutants, 1):
        if sys.stderr.isatty():
            print(f"\r{source.stem}: {number} of {len(mutants)} ", end="", file=sys.stderr, flush=True)
        source.write_text(mutant["text"], "utf-8")
        if trial(tests, log, quickest, limits).code == PASSED:
            left.append(mutant)
            print(f"survived: {name}:{mutant['line']} {mutant['function']}: {mutant['key']}", flush=True)
    source.write_text(text, "utf-8")
    del os.environ["PYTHONDONTWRITEBYTECODE"]
    os.environ.pop("XDG_CACHE_HOME", None)
    sys.dont_write_bytecode = False
    return left


def chosen(stems: list[str]) -> dict[str, list[str]]:
    """Return the modules of these stems, or all, with their tests."""
    modules: dict[str, list[str]] = yaml.safe_load((HERE / "modules.yaml").read_text("utf-8"))
    if unknown := set(stems) - {Path(module).stem for module in modules}:
        allowed = ", ".join(sorted(Path(module).stem for module in modules))
        sys.exit(f"mutate: error: unknown module {', '.join(sorted(unknown))}; allowed: {allowed}")
    wanted = [module for module in modules if not stems or Path(module).stem in stems]
    # From below: what is imported once must not be broken later.
    return {module: modules[module] for module in sorted(wanted, key=lambda m: -layer(Path(m).parts[0]))}


def prepared(copy: str) -> tuple[Path, dict[str, Explained]]:
    """Return the copy, in which the tests now run, and by module the survivors that are explained."""
    root = Path(copy).resolve()
    os.chdir(root)
    os.environ["WITHOUT_PHASES"] = "shrink explain"  # of hypothesis: that a mutant dies is enough
    sys.path[:0] = [str(path) for path in (root / "src").iterdir()]
    return root, yaml.safe_load((HERE / "survivors.yaml").read_text("utf-8"))


def main(generator: str, copy: str, *stems: str) -> int:
    """Print the survivors and the table; return 1 if a survivor is not explained."""
    (root, reasons), rows, old = prepared(copy), [], []
    for module, tests in chosen([*stems]).items():
        source, explained = root / "src" / module, reasons.get(module, {})
        mutants = made(generator, source)
        tried = [mutant for mutant in mutants if not is_explained(mutant, explained)]
        left = survivors(source, tried, tuple(f"test/{test}" for test in tests), root / "log")
        old += [f"{module} {line}" for line in outdated(mutants, explained)]
        rows.append(Row(source.name, len(mutants), len(mutants) - len(tried), len(left)))
    print(table(rows))
    for line in old:
        print(f"explained, but no mutant: {line}")
    return int(bool(old) or any(row.survived for row in rows))


def table(rows: list[Row]) -> str:
    """Return the rows and their sum as Markdown."""
    rows = [*rows, Row("all", *(sum(numbers) for numbers in list(zip(*rows, strict=True))[1:]))]
    lines = ["| module | mutants | killed | explained | survived |", "|---|---|---|---|---|"]
    for row in rows:
        killed = row.mutants - row.explained - row.survived
        lines.append(f"| `{row.module}` | {row.mutants} | {killed} | {row.explained} | {row.survived} |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
