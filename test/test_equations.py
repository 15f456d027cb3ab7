"""docs/explanation/equations.md and the docstrings agree: which thesis equation is computed where."""

import ast
import functools
import importlib
import inspect
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "explanation" / "equations.md"
DOCUMENT = PAGE.read_text("utf-8").partition("\n## ")[0]  # the table alone
KINDS = ("eq.", "App.", "section", "table", "fig.")
NUMBER = r"\d+(?:\.\d+)+[a-z]?|[AB]\b"
ITEM = re.compile(rf"(?:({'|'.join(map(re.escape, KINDS))}) )?({NUMBER})(?:-({NUMBER}))?(?:, | and )?")
ANY_SPELLING = re.compile(r"\bthesis[',]?\s+(?:eq|app|sect|tab|fig)\w*\.?", re.IGNORECASE)
ROW = re.compile(r"^\| ((?:eq\.|App\.|section|table|fig\.) \S+) \| ([^|]+) \|(.*)\|$", re.MULTILINE)


def citations(text):
    """Return what a docstring cites: {"eq. 3.1", "App. A", ...}; lists and ranges are taken apart."""
    found = set()
    words = " ".join(text.split())
    for start in re.finditer(r"\bThesis (?=(?:eq|App|section|table|fig)\b)", words):
        place, kind = start.end(), ""
        while match := ITEM.match(words, place):
            kind, place = match[1] or kind, match.end()
            if (match[2] in ("A", "B")) != (kind == "App."):  # "eq. 3.1, A piston"
                break
            found |= {f"{kind} {number}" for number in between(match[2], match[3])}
    return found


def between(first, last):
    """Return all equation numbers from the first to the last: 3.10-3.12 are three."""
    if last is None:
        return [first]
    (chapter, low), (_, high) = first.split("."), last.split(".")
    return [f"{chapter}.{number}" for number in range(int(low), int(high) + 1)]


def modules():
    """Return {dotted name: path} of every module and package of src."""
    paths = sorted(ROOT.glob("src/*/*/**/*.py"))
    dotted = (".".join(path.relative_to(ROOT).with_suffix("").parts[2:]) for path in paths)
    return {name.removesuffix(".__init__"): path for name, path in zip(dotted, paths, strict=True)}


MODULES = modules()


def module_of(name):
    """Return the module in which a class, function or method stands."""
    return next(m for m in (name.rsplit(".", n)[0] for n in (0, 1, 2)) if m in MODULES)


@functools.cache
def docstrings():
    """Return {dotted name of a module, class or function of src: its docstring}."""
    found = {}
    for module, path in MODULES.items():
        tree = ast.parse(path.read_text("utf-8"))
        found[module] = ast.get_docstring(tree) or ""
        for parent, node in [(tree, n) for n in tree.body] + [(n, m) for n in tree.body for m in members(n)]:
            if isinstance(node, ast.FunctionDef | ast.ClassDef):
                prefix = module if parent is tree else f"{module}.{parent.name}"
                found[f"{prefix}.{node.name}"] = ast.get_docstring(node) or ""
    return found


def members(node):
    return node.body if isinstance(node, ast.ClassDef) else []


def table():
    """Return [(citation, dotted names)] of the document's table."""
    return [(row[1], re.findall(r"`([\w.]+)`", row[2])) for row in ROW.finditer(DOCUMENT)]


TABLE = table()
LISTED = {(name, citation) for citation, names in TABLE for name in names}


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("Thesis eq. 3.1.", {"eq. 3.1"}),
        ("Thesis eq. 3.4-3.6, 4.5b and App. B: x", {"eq. 3.4", "eq. 3.5", "eq. 3.6", "eq. 4.5b", "App. B"}),
        (
            "(Thesis section 3.2.3, fig.\n 3.5), Thesis App. A, B.",
            {"section 3.2.3", "fig. 3.5", "App. A", "App. B"},
        ),
        ("Thesis eq. 3.1, A piston", {"eq. 3.1"}),
        ("the thesis has none", set()),
    ],
)
def test_citations_are_read_from_running_text(text, found):
    assert citations(text) == found


def test_citations_are_spelled_in_one_way():
    allowed = {f"Thesis {kind}" for kind in KINDS}
    wrong = {
        (name, " ".join(match[0].split()))
        for name, text in docstrings().items()
        for match in ANY_SPELLING.finditer(text)
        if " ".join(match[0].split()) not in allowed
    }
    assert not wrong


def test_no_equation_has_two_rows_or_an_empty_one():
    keys = [citation for citation, _ in TABLE]
    assert len(keys) > 30
    assert len(keys) == len(set(keys))
    assert all(names for _, names in TABLE)


def test_every_row_of_the_document_is_read():
    written = [line for line in DOCUMENT.splitlines() if re.match(r"\| (eq|App|section|table|fig)", line)]
    assert len(written) == len(TABLE)


@pytest.mark.parametrize("name", sorted({name for name, _ in LISTED}))
def test_what_the_table_names_exists(name):
    module = module_of(name)
    found = functools.reduce(
        getattr, name.removeprefix(f"{module}.").split("."), importlib.import_module(module)
    )
    assert inspect.isfunction(found) or inspect.isclass(found)


def test_every_function_of_the_table_cites_the_equation_itself_or_in_its_module():
    silent = {
        (name, citation)
        for name, citation in LISTED
        if citation not in citations(docstrings().get(name, "") + "\n" + docstrings()[module_of(name)])
    }
    assert not silent


def test_every_citation_of_a_function_is_in_the_table():
    cited = {(name, citation) for name, text in docstrings().items() for citation in citations(text)}
    unlisted = {(name, citation) for name, citation in cited if name not in MODULES} - LISTED
    in_modules = {(module_of(name), citation) for name, citation in LISTED}
    unlisted |= {(name, citation) for name, citation in cited if name in MODULES} - in_modules
    assert not unlisted
