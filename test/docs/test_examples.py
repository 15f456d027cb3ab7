"""Every example of the tutorials and the how-to guides runs, and prints what its page shows."""

import os
import re
import shutil
import sys
from pathlib import Path

import pytest
from page_examples import examples, matches, run_page

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
FIRST = "tutorials/first-demo.md"  # leaves the bag that other pages look at


def changes_sources(page):
    """Tell whether a page's reader changes the sources."""
    return any(one.kind == "diff" for one in examples(DOCS / page))


# Who changes sources comes last: then no kernel fits them, and nodes run interpreted, for the pages after it.
PAGES = sorted(
    (
        path.relative_to(DOCS).as_posix()
        for room in ("tutorials", "how-to")
        for path in (DOCS / room).glob("*.md")
    ),
    key=lambda page: (changes_sources(page), page),
)

# The one place that lists what is not run: page, and how many of its blocks.
NOT_RUN = {
    "tutorials/drive-live.md": 2,
    "tutorials/identify-a-crane.md": 1,
    "tutorials/write-a-scheme.md": 1,
    "how-to/real-iron.md": 5,
    "how-to/drive-from-a-program.md": 3,
    "how-to/set-up-for-an-operator.md": 1,
    "how-to/teach-a-cycle.md": 3,
    "how-to/drive-from-a-browser.md": 3,
    "how-to/use-a-joystick.md": 2,
    "how-to/another-machine.md": 1,
    "how-to/carry-a-log.md": 1,
    "how-to/record-recover-replay.md": 1,
    "how-to/debug-in-lockstep.md": 2,
    "how-to/sweep.md": 1,
    "how-to/tune.md": 1,
    "how-to/move-logs.md": 3,
    "how-to/secure-the-graph.md": 2,
    "how-to/two-hosts.md": 4,
    "how-to/open-in-rviz-foxglove-plotjuggler.md": 5,
}


@pytest.fixture(scope="module")
def workplace(tmp_path_factory, session_domain_id):
    """Folder and environment of a reader; sources come with the first page that changes them."""
    folder = tmp_path_factory.mktemp("checkout")
    (folder / ".venv" / "bin").mkdir(parents=True)
    (folder / ".venv" / "bin" / "activate").write_text("")
    (folder / "scripts").mkdir()
    for name in ("demo", "graph"):
        (module,) = re.findall(r" -m (\S+) ", (ROOT / "scripts" / f"{name}.sh").read_text("utf-8"))
        script = folder / "scripts" / f"{name}.sh"
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m {module} "$@"\n')
        script.chmod(0o755)
    environment = {
        **os.environ,
        "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}",
        "PYTHONPATH": ":".join(str(folder / "src" / path.name) for path in (ROOT / "src").iterdir()),
        "ROS_DOMAIN_ID": str(session_domain_id),
    }
    run_page(DOCS / FIRST, folder, environment)
    return folder, environment


def test_the_first_demo_leaves_its_bag(workplace):
    assert (workplace[0] / "bags" / "demo" / "bag" / "metadata.yaml").is_file()


@pytest.mark.parametrize("page", [page for page in PAGES if page != FIRST])
def test_a_page_runs_as_it_is_written(page, workplace):
    folder, environment = workplace
    if (folder / "src").exists() or changes_sources(page):
        shutil.copytree(ROOT / "src", folder / "src", dirs_exist_ok=True)
    run_page(DOCS / page, folder, environment)


def test_what_is_not_run_is_listed():
    left_out = {page: sum(bool(one.reason) for one in examples(DOCS / page)) for page in PAGES}
    assert {page: count for page, count in left_out.items() if count} == NOT_RUN


@pytest.mark.parametrize("page", PAGES)
def test_no_block_of_commands_is_overlooked(page):
    kinds = re.findall(r"^ *```(\w+)", (DOCS / page).read_text("utf-8"), re.MULTILINE)
    shell = sum(kind in ("sh", "bash", "shell") for kind in kinds)
    assert shell == sum(one.kind in ("sh", "bash", "shell") for one in examples(DOCS / page))


def test_expected_output_is_compared():
    assert matches("a 1\nb\nc\n", ["a …", "…", "c"])
    assert matches("a 1\n\n", ["a 1"])
    assert not matches("a 2\n", ["a 1"])
    assert not matches("a 1\nb\n", ["a 1"])


def test_a_failing_example_names_its_page_and_line(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Page\n\n```console\n$ false\n```\n")
    with pytest.raises(AssertionError, match=r"page\.md, line 3: exit code 1"):
        run_page(page, tmp_path, os.environ)
    page.write_text("```console\n$ echo 2\n1\n```\n")
    with pytest.raises(AssertionError, match=r"page\.md, line 1: printed was\n2"):
        run_page(page, tmp_path, os.environ)
