"""What the project is made of: licences that fit its own, and hashes of everything that is fetched."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "scripts"))
import licences

LOCKS = sorted(path.name for path in ROOT.glob("requirements*.lock"))


def test_the_licence_of_everything_that_is_installed_is_known_and_fits():
    told = licences.licences()
    assert {"numpy", "pyyaml", "mcap"} <= set(told)
    assert licences.misfits(told) == []


@pytest.mark.parametrize(
    "text", ["", "GPL-3.0-only", "GNU General Public License v3", "AGPL-3.0 OR MIT", "Proprietary"]
)
def test_a_licence_that_is_unknown_or_spreads_is_named(text):
    assert licences.misfits({"good": "MIT", "bad": text}) == ["bad"]


@pytest.mark.parametrize("lock", LOCKS)
def test_every_package_is_pinned_with_its_hashes(lock):
    logical = (ROOT / lock).read_text("utf-8").replace("\\\n", " ").splitlines()
    pins = [line for line in logical if line and not line.startswith((" ", "#"))]
    assert pins
    assert not [
        line for line in pins if not re.match(r"[a-z0-9._-]+==\S+ .*--hash=sha256:[0-9a-f]{64}", line)
    ]
