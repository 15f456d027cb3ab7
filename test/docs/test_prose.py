"""Pages can be read in a terminal and in a browser without a network, and their links lead somewhere."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
WIDTH = 100
PAGES = sorted(
    path.relative_to(ROOT).as_posix() for path in [*ROOT.glob("docs/**/*.md"), *ROOT.glob("[RC]*.md")]
)
LINK = re.compile(r"\]\(([^)\s]+)\)")


def prose(text: str) -> list[str]:
    """The lines of a page that are no code, no table, no equation; of a link its words alone."""
    without_code = re.sub(r"^( *)```.*?^\1```$", "", text, flags=re.MULTILINE | re.DOTALL)
    lines = [LINK.sub("]", line) for line in without_code.splitlines()]
    return [line for line in lines if not line.lstrip().startswith(("|", "<!--", "$$"))]


def test_code_tables_and_addresses_are_no_prose():
    text = "a [b](c.md)\n```sh\nx\n```\n| d |\n"
    assert prose(text) == ["a [b]", ""]


@pytest.mark.parametrize("page", [page for page in PAGES if page != "CHANGELOG.md"])
def test_no_line_of_prose_is_too_long(page):
    assert [line for line in prose((ROOT / page).read_text("utf-8")) if len(line) > WIDTH] == []


@pytest.mark.parametrize("page", [*PAGES, "bags/README.md", "benchmarks/README.md"])
def test_every_link_to_a_file_leads_to_one(page):
    text = re.sub(r"```.*?```", "", (ROOT / page).read_text("utf-8"), flags=re.DOTALL)
    targets = [link.partition("#")[0] for link in LINK.findall(text) if ":" not in link]
    folder = (ROOT / page).parent
    assert [target for target in targets if target and not (folder / target).exists()] == []


@pytest.mark.parametrize("page", [page for page in PAGES if page.startswith("docs/")])
def test_no_picture_is_fetched_from_elsewhere(page):
    assert not re.search(r"!\[[^\]]*\]\(\s*(https?:)?//", (ROOT / page).read_text("utf-8"))
