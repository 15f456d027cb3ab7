"""Folder and environment of a reader of the pages, and which page needs what."""

import os
import re
import shutil
import sys
from pathlib import Path

from page_examples import examples, run_page

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
FIRST = "tutorials/first-demo.md"  # leaves the bag that other pages look at
LIVE = re.compile(r"scripts/(graph\.sh|demo\.sh(?!.* --lockstep))|forest-bag record")
PAGES = sorted(
    path.relative_to(DOCS).as_posix()
    for room in ("tutorials", "how-to")
    for path in (DOCS / room).glob("*.md")
)


def _runs(page: str, kind: str, pattern: str | re.Pattern[str]) -> bool:
    blocks = [one for one in examples(DOCS / page) if one.kind == kind and not one.reason]
    return any(re.search(pattern, one.text) for one in blocks)


def changes_sources(page: str) -> bool:
    """Tell whether a page's reader changes the sources."""
    return _runs(page, "diff", "")


def looks_at_the_demo(page: str) -> bool:
    """Tell whether a page reads the bag of the first demo."""
    return _runs(page, "console", "bags/demo")


def is_live(page: str) -> bool:
    """Tell whether a page's nodes keep time with the computer's clock."""
    return _runs(page, "console", LIVE)


def workplace(folder: Path, domain_id: int) -> dict[str, str]:
    """Make a reader's folder without sources; return the environment of commands in it."""
    (folder / ".venv" / "bin").mkdir(parents=True)
    (folder / ".venv" / "bin" / "activate").write_text("")
    (folder / "scripts").mkdir()
    for name in ("demo", "graph"):
        (module,) = re.findall(r" -m (\S+) ", (ROOT / "scripts" / f"{name}.sh").read_text("utf-8"))
        script = folder / "scripts" / f"{name}.sh"
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m {module} "$@"\n')
        script.chmod(0o755)
    return {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "PYTHONPATH": ":".join(str(folder / "src" / path.name) for path in (ROOT / "src").iterdir()),
        "ROS_DOMAIN_ID": str(domain_id),
    }


def read(page: str, folder: Path, environment: dict[str, str]) -> None:
    """Do what a page says; sources come with the first page that changes them."""
    if (folder / "src").exists() or changes_sources(page):
        shutil.copytree(ROOT / "src", folder / "src", dirs_exist_ok=True)
    run_page(DOCS / page, folder, environment)
