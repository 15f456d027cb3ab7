"""Writes a machine as an FMU: the unit, the machine's file, and all sources that it needs.

pythonfmu wraps them. The importing tool's Python needs numpy and PyYAML, and llvmlite to be fast.
"""

import importlib.resources
import json
import re
import tempfile
from pathlib import Path

from pythonfmu import Fmi2Causality
from pythonfmu.builder import FmuBuilder

from forest_description.config import source_tree
from forest_description.machine import load_machine
from forest_sim.fmi.crane_unit import MACHINE_FILE, CraneUnit

PACKAGES = ("forest_compile", "forest_description", "forest_msgs_py", "forest_sim")
SCRIPT = "forest_crane_unit.py"
UNIT = '''"""The unit of this FMU."""

from forest_sim.fmi.crane_unit import NAMESPACES, CraneUnit

# pythonfmu runs this anew for each unit, and then releases the namespace once more than it took it:
# without one more holder the second unit of a process would find it empty.
NAMESPACES.append(globals())
'''


def export(name_or_path: str, fmu: Path) -> tuple[int, int]:
    """Write a machine as an FMU for co-simulation (FMI 2.0); return how many inputs and outputs it has.

    Args:
        name_or_path: of the machine.
        fmu: the file to be made.

    Raises:
        MachineError: no such machine, or its file is wrong.
        OSError: the file cannot be written.
    """
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / SCRIPT
        script.write_text(UNIT, encoding="utf-8")
        files = _machine_files(name_or_path, Path(folder))
        sources = [Path(str(importlib.resources.files(package))) for package in PACKAGES]
        FmuBuilder.build_FMU(script, dest=fmu, project_files=[*files, *sources])
        unit = CraneUnit(instance_name=fmu.stem, resources=folder)
    kinds = [variable.causality for variable in unit.vars.values()]
    return kinds.count(Fmi2Causality.input), kinds.count(Fmi2Causality.output)


def _machine_files(name_or_path: str, folder: Path) -> list[Path]:
    """Write a machine's file and those that it is based on, each naming the next; return their paths."""
    own = f"based_on: below\nname: {json.dumps(load_machine(name_or_path).name)}\n"
    texts = [own, *(text for _, text in source_tree.texts(name_or_path))]
    names = [MACHINE_FILE, *(f"base_{number}.yaml" for number in range(1, len(texts)))]
    below = [*names[1:], ""]
    for name, base, text in zip(names, below, texts, strict=True):
        written = re.sub(r"^based_on:.*$", f"based_on: {base}", text, flags=re.MULTILINE)
        (folder / name).write_text(written, encoding="utf-8")
    return [folder / name for name in names]
