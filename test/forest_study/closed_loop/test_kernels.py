"""Every kernel's digest covers all that is translated for it; a type that changes makes another kernel."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("llvmlite")

import forest_description
from forest_compile import fingerprint
from forest_compile.frontend import frame, translate
from forest_control import compiled as control
from forest_control.pipeline import stop_profile
from forest_ident.actuator import kernel, steps
from forest_sim.hydraulics import port
from forest_sim.mechanics import friction
from forest_sim.sensors import sensor_run
from forest_sim.solver import integrator, plant_kernel
from forest_study.closed_loop import loop_kernel

KERNELS = {
    "plant": plant_kernel.KERNEL,
    "sensors": sensor_run.KERNEL,
    "controller": control.CONTROLLER,
    "driver": control.DRIVER,
    "loop": loop_kernel.KERNEL,
    "actuator": kernel.KERNEL,
}
LOOK = """
from forest_control import compiled as control
from forest_sim.sensors import sensor_run
from forest_sim.solver import plant_kernel
for kept in (plant_kernel.KERNEL, sensor_run.KERNEL, control.CONTROLLER, control.DRIVER):
    print(kept.ready() is not None)
"""


@pytest.mark.parametrize("name", KERNELS)
def test_the_digest_covers_every_function_that_is_translated(monkeypatch, name):
    entry = KERNELS[name].entry
    used, read = set(), frame.syntax_tree

    def recorded(function):
        used.add(function)
        return read(function)

    monkeypatch.setattr(translate, "syntax_tree", recorded)
    translate.llvm_ir(entry)
    covered = set(fingerprint.functions(entry))
    assert used <= covered
    assert len(used) >= 0.9 * len(covered) > 2  # and little else


@pytest.mark.parametrize(
    ("module", "name", "value", "others"),
    [
        (friction, "pressed", port.is_shut, {"plant", "loop", "actuator"}),
        (integrator, "GAMMA", 0.5, {"plant", "loop"}),
        (stop_profile, "velocity_left", port.is_shut, {"controller", "loop"}),
        (steps, "rate", port.is_shut, {"actuator"}),
    ],
)
def test_what_lies_deep_down_counts_for_the_kernels_that_use_it(monkeypatch, module, name, value, others):
    before = {key: fingerprint.digest(kept.entry) for key, kept in KERNELS.items()}
    monkeypatch.setattr(module, name, value)
    assert {key for key, kept in KERNELS.items() if fingerprint.digest(kept.entry) != before[key]} == others


@pytest.mark.parametrize(
    ("field", "ready"), [("", [True] * 4), ("    roughness: float = 0.0\n", [False, False, True, True])]
)
def test_a_hose_with_another_field_has_no_kernel_yet(tmp_path, field, ready):
    """An old kernel would take each number for the one before it."""
    for name in ("plant", "sensors", "controller", "driver"):
        KERNELS[name].kernel()
    copy = shutil.copytree(Path(forest_description.__file__).parent, tmp_path / "forest_description")
    text = (copy / "hydraulics" / "hose.py").read_text()
    assert text.count("    capacitance: float\n") == 1
    (copy / "hydraulics" / "hose.py").write_text(
        text.replace("    capacitance: float\n", f"    capacitance: float\n{field}")
    )
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    environment = os.environ | {"PYTHONPATH": path}
    child = subprocess.run([sys.executable, "-c", LOOK], env=environment, capture_output=True, text=True)
    assert child.stdout.split() == list(map(str, ready)), child.stderr
