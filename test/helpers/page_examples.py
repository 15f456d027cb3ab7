"""Examples of the documentation's pages: the fenced blocks of a page, run in order as a reader would.

| block | what happens |
|---|---|
| `console` | the lines after `$ ` are a bash script that must exit with 0 and print the other lines |
| `title="FILE"` | is written to FILE |
| `diff` | is applied with `git apply` |
| `python` | is run as a script |

In expected output `…` stands for any text of a line, and alone on a line for any lines. A block below the
comment `<!-- not run: REASON -->` is left out. Blocks of other languages are read by people alone.
"""

import re
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

FENCE = re.compile(
    r"(?:<!-- not run: (?P<reason>.*?) -->\n\s*)?^ *```(?P<kind>\w*)(?P<info>.*)\n(?P<text>(?:.*\n)*?) *```$",
    re.MULTILINE,
)
RUN = {"console", "python", "diff"}
LIMIT_S = 300.0  # at which a test fails rather than hangs


class Example(NamedTuple):
    """One block of a page."""

    line: int
    kind: str
    title: str
    text: str
    reason: str  # why it is not run, if it is not


def examples(page: Path) -> Iterator[Example]:
    """Give the blocks of a page in order that a machine could run."""
    text = page.read_text("utf-8")
    for match in FENCE.finditer(text):
        title = re.search(r'title="([^"]+)"', match["info"])
        if match["kind"] in RUN or title or match["reason"]:
            line = text.count("\n", 0, match.start("kind")) + 1
            yield Example(
                line, match["kind"], title[1] if title else "", match["text"], match["reason"] or ""
            )


def run_page(page: Path, folder: Path, environment: Mapping[str, str]) -> None:
    """Run a page's examples in a folder.

    Raises:
        AssertionError: an example fails, or prints something else; the text names page and line.
    """
    for example in examples(page):
        if example.reason:
            continue
        if example.title:
            target = folder / example.title
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_text(example.text, encoding="utf-8")
            continue
        lines = example.text.splitlines()
        commands = {
            "console": [
                "bash",
                "-euo",
                "pipefail",
                "-c",
                "\n".join(x[2:] for x in lines if x[:2] in ("$ ", "> ")),
            ],
            "python": [sys.executable, "-c", example.text],
            "diff": ["git", "apply", "-"],
        }
        done = subprocess.run(
            commands[example.kind],
            input=example.text if example.kind == "diff" else "",
            cwd=folder,
            env=dict(environment),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=LIMIT_S,
            check=False,
        )
        where = f"{page.name}, line {example.line}"
        assert done.returncode == 0, f"{where}: exit code {done.returncode}\n{done.stdout}"
        wanted = [x for x in lines if x[:2] not in ("$ ", "> ")] if example.kind == "console" else []
        assert not wanted or matches(done.stdout, wanted), f"{where}: printed was\n{done.stdout}"


def matches(printed: str, wanted: list[str]) -> bool:
    """Tell whether a text is what a page shows of it."""
    parts = [
        r"(?:.*\n)*?" if line.strip() == "…" else re.escape(line.rstrip()).replace("…", ".*?") + r"\s*?\n"
        for line in wanted
        if line.strip()
    ]
    lines = [line.rstrip() for line in printed.replace("\r", "\n").splitlines() if line.strip()]
    return re.fullmatch("".join(parts), "".join(f"{line}\n" for line in lines)) is not None
