"""A browser for all tests of a module: starting one takes a second."""

import pytest
from browser import launched


@pytest.fixture(scope="module")
def browser():
    """A headless Chromium."""
    with launched() as running:
        yield running
