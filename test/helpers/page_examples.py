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
PROMPTS = ("$ ", "> ")
LIMIT_S = 300.0  # at which a test fails rather than hangs
PASSING = re.compile(r"^ *\[#*\.*\] +\d+ %")  # progress bars, which come on some computers only


class Example(NamedTuple):
    """One block of a page."""

    line: int
    kind: str
    title: str  # the file that it is written to, if it is
    text: str
    reason: str  # why it is not run, if it is not

    @property
    def commands(self) -> str:
        """The script of a `console`."""
        return "\n".join(line[2:] for line in self.text.splitlines() if line.startswith(PROMPTS))

    @property
    def shown(self) -> list[str]:
        """The lines that a `console` prints, as far as the page shows them."""
        lines = self.text.splitlines() if self.kind == "console" else []
        return [line for line in lines if not line.startswith(PROMPTS)]


def examples(page: Path) -> Iterator[Example]:
    """Give the blocks of a page in order that a machine could run."""
    text = page.read_text("utf-8")
    for match in FENCE.finditer(text):
        title = re.search(r'title="([^"]+)"', match["info"])
        if match["kind"] in RUN or title or match["reason"]:
            line = text.count("\n", 0, match.start("kind")) + 1
            file = title[1] if title else ""
            yield Example(line, match["kind"], file, match["text"], match["reason"] or "")


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
        code, printed = run(example, folder, environment)
        where = f"{page.name}, line {example.line}"
        assert code == 0, f"{where}: exit code {code}\n{printed}"
        assert not example.shown or matches(printed, example.shown), f"{where}: printed was\n{printed}"


def run(example: Example, folder: Path, environment: Mapping[str, str]) -> tuple[int, str]:
    """Run one block; return its exit code and what it printed."""
    command = {
        "console": ["bash", "-euo", "pipefail", "-c", example.commands],
        "python": [sys.executable, "-c", example.text],
        "diff": ["git", "apply", "-"],
    }[example.kind]
    done = subprocess.run(
        command,
        input=example.text if example.kind == "diff" else "",
        cwd=folder,
        env=dict(environment),
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
        check=False,
    )
    return done.returncode, done.stdout


def matches(printed: str, wanted: list[str]) -> bool:
    """Tell whether a text is what a page shows of it."""
    parts = [
        r"(?:.*\n)*?" if line.strip() == "…" else re.escape(line.rstrip()).replace("…", ".*?") + r"\n"
        for line in wanted
        if line.strip()
    ]
    lines = [line.rstrip() for line in printed.splitlines() if line.strip() and not PASSING.search(line)]
    return re.fullmatch("".join(parts), "".join(f"{line}\n" for line in lines)) is not None
