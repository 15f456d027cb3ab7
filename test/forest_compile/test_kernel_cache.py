"""Claims that machine code is linked, and loaded only as it was written, by its user."""

import math
import os
import shutil
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

pytest.importorskip("llvmlite")

from forest_compile import kernel_cache, kernel_files, machine_code
from forest_compile.entry import Entry
from forest_compile.kernel_cache import CachedKernel


class Point(NamedTuple):
    x: float
    y: float


def law(p):
    return (1.5 + math.sin(p.x)) ** 2.5 + math.exp(p.y) * math.cos(p.x) - math.atan2(p.y, p.x) % 0.3


def other_law(p):
    return p.x - p.y


def cached(function=law, name="law"):
    """Return a kernel of a law, as another process would see it."""
    text, tuples = "def kernel(given, results):\n    results[0] = law(p)", {"p": ("given", Point(1.0, 2.0))}
    return CachedKernel(name, lambda: Entry(text, {"law": function}, "pp", tuples))


def result(kernel, x=0.7, y=-0.4):
    given, results = np.array([x, y]), np.empty(1)
    kernel(given.ctypes.data, results.ctypes.data)
    return results[0]


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    """A cache of the test's own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "forest_sim"


@pytest.fixture(params=["shared", "object"])
def form(request, monkeypatch):
    """With a linker and without."""
    if request.param == "object":
        monkeypatch.setattr(machine_code, "LINKERS", ())
    elif not any(map(shutil.which, machine_code.LINKERS)):
        pytest.skip("no linker is installed")
    return {"shared": ".so", "object": ".o"}[request.param]


def assert_refused(caplog, *words):
    """It is not used, and one sentence says why; who may compile makes it anew."""
    assert cached().ready() is None
    (record,) = caplog.records
    assert all(word in record.getMessage() for word in ("law is not used", *words, "run interpreted"))
    assert "\n" not in record.getMessage()
    assert result(cached().kernel()) == law(Point(0.7, -0.4))
    assert "made anew" in caplog.records[-1].getMessage()
    caplog.clear()
    assert result(cached().ready()) == law(Point(0.7, -0.4))
    assert not caplog.records


def test_a_kernel_is_there_for_the_next_process(form, cache):
    assert cached().ready() is None
    one = cached()
    assert result(one.kernel()) == law(Point(0.7, -0.4))
    assert one.file.suffix == form
    assert one.file.parent == cache
    assert [cache.stat().st_mode & 0o777, one.file.stat().st_mode & 0o777] == [0o700, 0o600]
    assert result(cached().ready()) == law(Point(0.7, -0.4))


def test_who_makes_kernels_is_told_where_they_are_or_that_nodes_will_run_interpreted(capsys, monkeypatch):
    one = cached()
    assert kernel_cache.make(one) == 0
    assert capsys.readouterr().out == f"{one.file}\n"
    assert kernel_cache.make(SimpleNamespace(kernel=lambda: None, file=None), one) == 1
    assert not capsys.readouterr().out
    monkeypatch.setattr(kernel_cache, "can_compile", lambda: False)
    assert kernel_cache.make(one) == 1
    assert capsys.readouterr().out == "llvmlite is not installed\n"


def test_two_who_want_a_kernel_at_once_make_it_once(monkeypatch):
    both, made, optimised = threading.Event(), [], machine_code.optimised

    def slow(code):
        made.append(code)
        if len(made) == 1:
            other.start()
            both.wait(0.5)  # passes unless the other waits, as it should
        both.set()
        return optimised(code)

    def ask():
        found.append(result(cached().kernel()))

    found, other = [], threading.Thread(target=ask)
    monkeypatch.setattr(machine_code, "optimised", slow)
    ask()
    other.join()
    assert len(made) == 1
    assert found == [law(Point(0.7, -0.4))] * 2


def test_linked_and_unlinked_code_are_the_same_to_the_last_bit(monkeypatch):
    if not any(map(shutil.which, machine_code.LINKERS)):
        pytest.skip("no linker is installed")
    linked = cached()
    assert linked.kernel()
    monkeypatch.setattr(machine_code, "LINKERS", ())
    unlinked = cached(name="unlinked")
    assert unlinked.kernel()
    assert [linked.file.suffix, unlinked.file.suffix] == [".so", ".o"]
    for x, y in np.random.default_rng(3).normal(0.0, 2.0, (100, 2)):
        assert result(linked.kernel(), x, y) == result(unlinked.kernel(), x, y)


@pytest.mark.parametrize(
    "damage",
    [
        lambda code: b"",
        lambda code: code[:10],
        lambda code: code[: len(code) // 2],
        lambda code: code[:-1],
        lambda code: code[:200] + bytes([code[200] ^ 1]) + code[201:],
        lambda code: b"\0" * len(code),
    ],
)
def test_a_damaged_file_is_made_anew(form, caplog, damage):
    one = cached()
    one.kernel()
    file = one.file
    file.write_bytes(damage(file.read_bytes()))
    assert one.file is None
    assert_refused(caplog, str(file), "damaged")


def test_one_kernels_file_is_not_anothers(form, caplog):
    one, other = cached(), cached(other_law, "other")
    one.kernel()
    other.kernel()
    one.file.write_bytes(other.file.read_bytes())
    assert_refused(caplog, "damaged")


def test_a_file_or_directory_that_others_can_write_is_not_used(form, cache, caplog):
    one = cached()
    one.kernel()
    file = one.file
    file.chmod(0o620)
    assert_refused(caplog, str(file), "written by others", "620")
    caplog.clear()
    cache.chmod(0o703)
    assert_refused(caplog, f"{cache} can be written by others", "703")
    assert cache.stat().st_mode & 0o777 == 0o700


def test_a_cache_is_made_with_all_folders_above_it(form, cache, monkeypatch, caplog):
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache.parent / "no" / "such"))
    cached().kernel()
    assert [file.suffix for file in (cache.parent / "no" / "such" / "forest_sim").iterdir()] == [form]
    assert not caplog.records


def test_a_link_is_not_followed(form, cache, caplog):
    one = cached()
    one.kernel()
    file = one.file
    file.symlink_to(file.rename(cache / "real"))
    assert_refused(caplog, f"{file} is a link")


def test_a_folder_or_a_pipe_is_no_kernel(form, cache, caplog):
    for make in (os.mkdir, os.mkfifo):
        one = cached()
        one.kernel()
        file = one.file
        file.unlink()
        make(file, 0o700)
        opened = sorted(Path("/proc/self/fd").iterdir())
        assert cached().ready() is None
        assert f"{file} is no file" in caplog.text
        assert sorted(Path("/proc/self/fd").iterdir()) == opened
        caplog.clear()
        file.rmdir() if file.is_dir() else file.unlink()


def test_a_linked_directory_is_not_used_nor_written_to(form, cache, tmp_path, caplog):
    cached().kernel()
    cache.rename(tmp_path / "real")
    cache.symlink_to(tmp_path / "real")
    (tmp_path / "real").chmod(0o755)
    before = [(file, file.stat().st_mtime_ns) for file in (tmp_path / "real").iterdir()]
    assert cached().ready() is None
    assert f"{cache} is a link" in caplog.text
    one = cached()
    assert result(one.kernel()) == law(Point(0.7, -0.4))
    assert "cannot be kept" in caplog.text
    assert one.file is None
    assert before == [(file, file.stat().st_mtime_ns) for file in (tmp_path / "real").iterdir()]
    assert (tmp_path / "real").stat().st_mode & 0o777 == 0o755


def test_another_users_file_is_not_used(form, cache, caplog, monkeypatch):
    """It is the asker who is another here: only root could give files away."""
    one = cached()
    one.kernel()
    cache.chmod(0o755)
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    assert cached().ready() is None
    assert f"belongs to user {os.getuid()}, not to {os.getuid() + 1}" in caplog.text
    assert result(cached().kernel()) == law(Point(0.7, -0.4))
    assert "cannot be kept" in caplog.text
    assert cache.stat().st_mode & 0o777 == 0o755


def test_without_the_systems_word_the_cache_lies_at_home(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    for unset in (
        lambda: monkeypatch.setenv("XDG_CACHE_HOME", ""),
        lambda: monkeypatch.delenv("XDG_CACHE_HOME"),
    ):
        unset()
        assert kernel_files.directory() == tmp_path / ".cache" / "forest_sim"


def test_another_translator_or_law_makes_another_kernel(tmp_path, monkeypatch):
    package = tmp_path / "package"
    (package / "frontend").mkdir(parents=True)
    sources = [package / "kernel_cache.py", package / "frontend" / "translate.py"]
    monkeypatch.setattr(kernel_cache, "__file__", str(sources[0]))
    for source in sources:
        source.write_text("one")
    named = [cached()._shared.name, cached()._shared.name]
    for source in sources:
        source.write_text("other")
        named.append(cached()._shared.name)
    named.append(cached(other_law)._shared.name)
    assert named[0] == named[1]
    assert len(set(named)) == 4


def test_linked_code_brings_the_mathematics_that_it_calls():
    """Whoever loads it may not have that library."""
    if not any(map(shutil.which, machine_code.LINKERS)):
        pytest.skip("no linker is installed")
    one = cached()
    assert one.kernel()
    assert b"\0libm.so.6\0" in one.file.read_bytes()


def test_a_cache_that_cannot_be_written_costs_only_time(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert result(cached().kernel()) == law(Point(0.7, -0.4))
    assert "the machine code of law cannot be kept" in caplog.text
    assert cached().ready() is None


def test_what_the_system_does_not_load_is_kept_as_object_code(monkeypatch, caplog):
    monkeypatch.setattr(machine_code, "linked", lambda code: b"not a shared object")
    one = cached()
    assert result(one.kernel()) == law(Point(0.7, -0.4))
    assert one.file.suffix == ".o"
    assert result(cached().ready()) == law(Point(0.7, -0.4))
    assert not caplog.records


def test_a_linker_that_fails_makes_way_for_the_next(tmp_path, monkeypatch):
    found = next(filter(None, map(shutil.which, machine_code.LINKERS)), None)
    if found is None:
        pytest.skip("no linker is installed")
    monkeypatch.setattr(machine_code, "LINKERS", ("false", found))
    assert cached().kernel()
    assert cached().file.suffix == ".so"


NODES = """
import sys
from forest_control import compiled as control
from forest_sim.sensors import sensor_run
from forest_sim.solver import plant_kernel
kernels = control.CONTROLLER, control.DRIVER, plant_kernel.KERNEL, sensor_run.KERNEL
print([kept.ready() is not None for kept in kernels], [kept.file.suffix for kept in kernels])
print("llvmlite" in sys.modules, "forest_compile.frontend.translate" in sys.modules)
"""


def test_nodes_load_linked_kernels_without_the_compiler(monkeypatch):
    if not any(map(shutil.which, machine_code.LINKERS)):
        pytest.skip("no linker is installed")
    monkeypatch.delenv("XDG_CACHE_HOME")  # where the other tests' kernels lie, too
    for module in ("forest_control.compiled", "forest_sim.compiled"):
        subprocess.run([sys.executable, "-m", module], check=True, capture_output=True)
    done = subprocess.run([sys.executable, "-c", NODES], check=True, capture_output=True, text=True)
    assert done.stdout.splitlines() == [f"{[True] * 4} {['.so'] * 4}", "False False"]
    assert not done.stderr


def test_the_file_is_whole_while_another_process_writes_it(cache):
    """It appears under its name only when it is written."""
    kernel_files.write(cache / "x.so", b"code")
    assert [file.name for file in cache.iterdir()] == ["x.so"]
    assert kernel_files.read(cache / "x.so") == b"code"
    assert kernel_files.read(cache / "y.so") is None
