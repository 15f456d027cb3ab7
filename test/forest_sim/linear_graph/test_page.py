"""docs/explanation/linear-graphs.md and its graphs/ are what the code writes."""

import subprocess
import sys
from pathlib import Path

import pytest
import sympy
from sympy import Symbol

from forest_sim.linear_graph import page as graph_page
from forest_sim.linear_graph.layouts import CIRCUITS
from forest_sim.linear_graph.page import name_denominators

DOCS = Path(__file__).resolve().parents[3] / "docs" / "explanation"


@pytest.fixture(scope="module")
def written():
    return graph_page.files()


def test_the_committed_files_are_what_the_command_writes(written):
    committed = {f"graphs/{path.name}" for path in (DOCS / "graphs").iterdir()} | {"linear-graphs.md"}
    assert committed == set(written)
    for name, text in written.items():
        assert (DOCS / name).read_text("utf-8") == text, f"{name}: run python -m forest_sim.linear_graph.page"


def test_the_command_writes_all_files(written, tmp_path, monkeypatch):
    monkeypatch.setattr("sys.argv", ["graph_page", str(tmp_path)])
    monkeypatch.setattr(graph_page, "files", lambda: written)
    graph_page.main()
    assert {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.*")} == set(written)


def test_the_page_shows_every_circuit_with_its_drawing(written):
    page = written["linear-graphs.md"]
    for circuit in CIRCUITS:
        assert f"## {circuit.title}\n" in page
        assert f"(graphs/{circuit.file}.svg)" in page


@pytest.mark.parametrize(("place", "told"), [(0, "R_v1"), (1, None)])
def test_the_pages_examples_run_and_print_what_is_told(written, capsys, place, told):
    code, _, after = written["linear-graphs.md"].split("```python\n")[1 + place].partition("```")
    exec(compile(code, "linear-graphs.md", "exec"), {})
    assert (told or after.partition("```text\n")[2].partition("```")[0]) in capsys.readouterr().out


def test_no_table_cell_is_torn_by_a_bar(written):
    rows = [line for line in written["linear-graphs.md"].splitlines() if line.startswith("|")]
    assert len(rows) > 60
    assert {row.count("|") for row in rows} == {7}


def test_sums_under_a_fraction_get_names():
    a, b, x = (Symbol(name, positive=True) for name in "abx")
    one, sums = name_denominators([x / (a + b), x / a, a / (a + b)])
    (delta,) = sums
    assert one == [x / delta, x / a, a / delta]
    assert sums[delta] == a + b
    two, sums = name_denominators([x / (a + b), x / (a + 2 * b)])
    assert [symbol.name for symbol in sums] == [r"\Delta_{1}", r"\Delta_{2}"]
    assert [
        sympy.simplify(e.xreplace(sums) - x / d) for e, d in zip(two, (a + b, a + 2 * b), strict=True)
    ] == [0, 0]


def test_without_sympy_the_command_names_it_and_writes_nothing(tmp_path):
    absent = (
        "import runpy, sys; sys.modules['sympy'] = None; "
        "runpy.run_module('forest_sim.linear_graph.page', run_name='__main__')"
    )
    done = subprocess.run(
        [sys.executable, "-c", absent, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert done.stderr.startswith("the page needs sympy; allowed: scripts/setup.sh test")
    assert done.stderr.count("\n") == 1
    assert not any(tmp_path.iterdir())
