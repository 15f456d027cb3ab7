"""README, CONTRIBUTING and docs/explanation name tests, modules and files that exist, in lines that fit."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs" / "explanation").glob("*.md")),
]
CODE = [path for folder in ("src", "test", "benchmarks", "scripts") for path in (ROOT / folder).rglob("*.py")]
MODULES = {path.name for path in CODE}
TESTS = {
    name
    for path in CODE
    if path.name.startswith("test_")
    for name in re.findall(r"^def (test_\w+)", path.read_text("utf-8"), re.MULTILINE)
}
WIDTH = 100


def prose(text):
    """Return the lines that are neither code, nor a table, nor a formula."""
    open_text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    return [line for line in open_text.splitlines() if not line.startswith(("|", "$$", "!["))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_lines_of_prose_fit(page):
    assert [line for line in prose(page.read_text("utf-8")) if len(line) > WIDTH] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_tests_and_modules_that_a_page_names_exist(page):
    text = page.read_text("utf-8")
    modules = set(re.findall(r"`([a-z_0-9]+\.py)`", text))
    assert modules - MODULES == set()
    named = re.findall(r"`(test_[a-z_0-9]+)(\.\.\.)?`", text)
    assert {name for name, open_end in named if not open_end} - TESTS == set()
    starts = [name for name, open_end in named if open_end]
    assert [start for start in starts if not any(name.startswith(start) for name in TESTS)] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_to_a_file_and_every_anchor_to_a_heading(page):
    for target, anchor in re.findall(r"\]\(([^)#:]*)(?:#([^)]*))?\)", page.read_text("utf-8")):
        file = page.parent / target if target else page
        assert file.exists(), target
        if anchor:
            assert anchor in anchors(file.read_text("utf-8")), f"{target}#{anchor}"


def anchors(text):
    """Return the anchors of a page's headings, as GitHub and mkdocs make them."""
    heads = re.findall(
        r"^#+ (.*)$", re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL), re.MULTILINE
    )
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
