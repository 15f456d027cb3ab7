"""Every example of the tutorials and the how-to guides runs, and prints what its page shows.

Pages that run nodes live, or change the sources and need no bag, are in files of their own: files run side by
side.
"""

import os
import re

import pytest
from page_examples import examples, matches, run_page
from page_reader import DOCS, FIRST, PAGES, changes_sources, is_live, looks_at_the_demo, read, workplace

HERE = [
    page
    for page in PAGES
    if page != FIRST and not is_live(page) and (looks_at_the_demo(page) or not changes_sources(page))
]
# Who changes sources comes last: then no kernel fits them, and nodes run interpreted, for the pages after it.
HERE.sort(key=changes_sources)

# The one place that lists what is not run: page, and how many of its blocks.
NOT_RUN = {
    "tutorials/drive-live.md": 2,
    "tutorials/identify-a-crane.md": 1,
    "tutorials/write-a-scheme.md": 1,
    "how-to/real-iron.md": 5,
    "how-to/drive-from-a-program.md": 4,
    "how-to/set-up-for-an-operator.md": 1,
    "how-to/teach-a-cycle.md": 3,
    "how-to/drive-from-a-browser.md": 3,
    "how-to/use-a-joystick.md": 2,
    "how-to/another-machine.md": 1,
    "how-to/diagnose.md": 1,
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
def reader(tmp_path_factory, lockstep_domain_id):
    """Folder and environment of a reader who has done the first demo."""
    folder = tmp_path_factory.mktemp("checkout")
    environment = workplace(folder, lockstep_domain_id)
    run_page(DOCS / FIRST, folder, environment)
    return folder, environment


def test_the_first_demo_leaves_its_bag(reader):
    assert (reader[0] / "bags" / "demo" / "bag" / "metadata.yaml").is_file()


@pytest.mark.parametrize("page", HERE)
def test_a_page_runs_as_it_is_written(page, reader):
    read(page, *reader)


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
