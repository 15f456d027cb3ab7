"""HTML pages from the templates beside this module: one file, with its figures inside."""

import base64
import io
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup, escape

from forest_ident.estimators.parameter_estimate import NORMAL_95
from forest_ident.validation.prediction_error import limit

LOADER = FileSystemLoader(Path(__file__).parent / "templates")
ENVIRONMENT = Environment(
    loader=LOADER,
    autoescape=True,
    trim_blocks=True,
    undefined=StrictUndefined,
)
ENVIRONMENT.globals["normal_95"] = NORMAL_95
ENVIRONMENT.globals["limit"] = limit


def _breakable(key: str) -> Markup:
    """Return a dotted key that may be broken after its points and underscores."""
    return escape(key).replace(".", Markup(".<wbr>")).replace("_", Markup("_<wbr>"))


ENVIRONMENT.filters["breakable"] = _breakable


def render(template: str, **content: Any) -> str:
    """Return a template of this room with its content filled in, HTML escaped."""
    return ENVIRONMENT.get_template(template).render(**content)


def write(file: Path, template: str, **content: Any) -> Path:
    """Write a page into a directory to be made; return its path.

    Raises:
        OSError: it cannot be written.
    """
    text = render(template, **content)
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    return file


def image(figure: Any) -> str:
    """Return a figure as the source of an image inside the page."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return f"data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}"
