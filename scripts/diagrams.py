"""Draws a page's Mermaid blocks while MkDocs builds it: a browser would fetch a library from the network."""

import re
from typing import Any

import mermaidx

BLOCK = re.compile(r"^```mermaid\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Return a page's text with pictures in place of its Mermaid blocks.

    Raises:
        RuntimeError: a block cannot be drawn; the text has its line.
    """
    return BLOCK.sub(_picture, markdown)


def _picture(block: re.Match[str]) -> str:
    picture = mermaidx.render(block[1]).svg()
    return f'<div class="diagram">{" ".join(picture.split())}</div>'
