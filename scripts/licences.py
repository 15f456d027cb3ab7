"""Prints the licence of everything that requirements.lock installs; exit code 1: one is not known to fit.

The project is under Apache-2.0 and links what it imports, so what it needs must be permissive, or a copyleft
that ends at the file. A wheel of ROS tells its licence in the manifest that it installs.
"""

import re
import sys
from collections.abc import Iterator
from importlib.metadata import Distribution, distributions
from pathlib import Path
from xml.etree import ElementTree

LOCK = Path(__file__).resolve().parents[1] / "requirements.lock"
FITS = re.compile(
    r"(Apache|BSD|0BSD|MIT|PSF|Python Software Foundation|Zlib|zlib|CC0|ISC|MPL|any-OSI|names others only)",
    re.IGNORECASE,
)
NEVER = re.compile(r"\b(A?GPL|GNU (Affero )?General|Proprietary|SSPL)", re.IGNORECASE)
ELSEWHERE = {
    "ros-fastcdr": "Apache License 2.0",
    "ros-fastrtps": "Apache License 2.0",
    "ros-jazzy-common-interfaces": "names others only",
    "ros-jazzy-rclpy": "names others only",
    "ros-jazzy-rmw-fastrtps-cpp": "names others only",
}
"""Where the wheel says nothing: LICENSE of eProsima's repositories, and wheels without a file."""
LONGEST = 80  # letters of a licence's name; a longer one is its text, and begins with the name


def locked() -> set[str]:
    """Return the names in the lock; some are for other Pythons."""
    return set(re.findall(r"^([a-z0-9][a-z0-9._-]*)==", LOCK.read_text("utf-8"), re.MULTILINE))


def plain(name: str) -> str:
    """Return a distribution's name as locks have it."""
    return re.sub(r"[-_.]+", "-", name).lower()


def licence(found: Distribution) -> str:
    """Return what a distribution says of its licence, or ""."""
    told = found.metadata
    classifiers = [
        text.rpartition(" :: ")[2] for text in told.get_all("Classifier") or [] if "License" in text
    ]
    first = (told.get("License") or "").strip().splitlines()[:1]
    said = told.get("License-Expression") or "; ".join(classifiers) or "".join(first)
    told_so = said[:LONGEST] or "; ".join(manifest_licences(found))
    return told_so or ELSEWHERE.get(plain(found.metadata["Name"]), "")


def manifest_licences(found: Distribution) -> Iterator[str]:
    """Give the licences of the ROS manifests that a distribution installs."""
    for path in found.files or ():
        if path.name == "package.xml":
            root = ElementTree.fromstring(Path(str(path.locate())).read_text("utf-8"))
            yield from (str(element.text) for element in root.iter("license"))


def licences() -> dict[str, str]:
    """Return the licence of each distribution that is installed of the lock."""
    wanted = locked()
    named = {plain(found.metadata["Name"]): found for found in distributions()}
    return {name: licence(named[name]) for name in sorted(wanted & set(named))}


def misfits(told: dict[str, str]) -> list[str]:
    """Return the names whose licence is not known to fit."""
    return [name for name, text in told.items() if not FITS.search(text) or NEVER.search(text)]


def main() -> int:
    """Print the list; return 1 if a licence is not known to fit."""
    told = licences()
    for name, text in told.items():
        print(f"{name:42} {text}")
    unknown = misfits(told)
    print(f"{len(told)} packages; not known to fit: {', '.join(unknown) or 'none'}")
    return int(bool(unknown))


if __name__ == "__main__":
    sys.exit(main())
