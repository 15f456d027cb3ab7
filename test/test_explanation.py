"""The pages that explain name tests, modules and headings that exist."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
EXPLANATION = ROOT / "docs" / "explanation"
CITING = "safety", "safety-evidence", "control", "valve-driver", "results", "equations", "identification"
CODE = [path for folder in ("src", "test", "benchmarks", "scripts") for path in (ROOT / folder).rglob("*.py")]
MODULES = {path.name for path in CODE}
TESTS = {
    name
    for path in CODE
    if path.name.startswith("test_")
    for name in re.findall(r"^def (test_\w+)", path.read_text("utf-8"), re.MULTILINE)
}


@pytest.mark.parametrize("page", CITING)
def test_tests_and_modules_that_a_page_names_exist(page):
    text = (EXPLANATION / f"{page}.md").read_text("utf-8")
    assert set(re.findall(r"`([a-z_0-9]+\.py)`", text)) - MODULES == set()
    named = re.findall(r"`(test_[a-z_0-9]+)(\.\.\.)?`", text)
    assert {name for name, open_end in named if not open_end} - TESTS == set()
    starts = [name for name, open_end in named if open_end]
    assert [start for start in starts if not any(name.startswith(start) for name in TESTS)] == []


@pytest.mark.parametrize(("page", "tables"), [("safety", 16), ("safety-evidence", 3)])
def test_a_claim_of_safety_names_its_test(page, tables):
    lines = [*(EXPLANATION / f"{page}.md").read_text("utf-8").splitlines(), ""]
    heads = [k for k, line in enumerate(lines) if line.startswith("| claim") and line.endswith("| test |")]
    assert len(heads) >= tables
    for head in heads:
        for row in lines[head + 2 : lines.index("", head)]:
            assert re.search(r"`test_\w+|the same|as above", row.rsplit("|", 2)[1]), row


@pytest.mark.parametrize("page", ["README.md", "CONTRIBUTING.md"])
def test_an_anchor_leads_to_a_heading(page):
    links = re.findall(r"\]\(([^)#]+\.md)#([^)]+)\)", (ROOT / page).read_text("utf-8"))
    assert links
    assert [(file, anchor) for file, anchor in links if anchor not in anchors(ROOT / file)] == []


def anchors(page):
    """Return the anchors of a page's headings, as GitHub makes them."""
    heads = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}
