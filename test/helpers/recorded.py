"""Recordings that others made: they are no part of the checkout, so a test finds them or is skipped."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[2]
VARIABLE = "FOREST_DATA"


def recorded(name: str, checkout: Path = CHECKOUT) -> Path:
    """Return the path of a recording; skip the test, and say where it was looked for, where there is none.

    It may be in the folder that FOREST_DATA names, or in shared/data beside the checkout.
    """
    named = os.environ.get(VARIABLE)
    folders = [*([Path(named)] if named else []), checkout.parent / "shared" / "data"]
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    hint = "" if named else f"; {VARIABLE} may name another folder"
    pytest.skip(f"{name} is not in {' nor in '.join(map(str, folders))}{hint}")
