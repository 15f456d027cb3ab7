"""One graph per ROS domain and namespace: two that command one crane are one too many."""

import contextlib
import fcntl
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path

HIGHEST_DOMAIN = 232  # above, the middleware runs out of ports


class GraphError(Exception):
    """The graph could not start or had to end; the message is one sentence for the user."""


class AlreadyRunning(GraphError):
    """Another graph is there; `sign` is what it was known by."""

    def __init__(self, namespace: str, sign: str) -> None:
        domain = os.environ.get("ROS_DOMAIN_ID", "0")
        super().__init__(
            f"a graph is already running in ROS domain {domain}, namespace {namespace} ({sign}); "
            "stop it, or choose another --namespace or ROS_DOMAIN_ID"
        )


@contextlib.contextmanager
def only_graph(namespace: str) -> Iterator[None]:
    """Hold the lock of this user's graph in the domain and namespace.

    Raises:
        AlreadyRunning: another supervisor holds it.
        GraphError: ROS_DOMAIN_ID is no domain, or the lock file cannot be written.
    """
    domain = os.environ.get("ROS_DOMAIN_ID") or "0"
    if not (domain.isascii() and domain.isdigit() and int(domain) <= HIGHEST_DOMAIN):
        raise GraphError(f"ROS_DOMAIN_ID is {domain!r}; allowed: 0 .. {HIGHEST_DOMAIN}")
    key = f"{os.getuid()}-{domain}{namespace.replace('/', '.')}"
    path = Path(tempfile.gettempdir()) / f"forest-graph-{key}.lock"
    try:
        file = path.open("a+", encoding="ascii")
    except OSError as error:
        raise GraphError(f"cannot write the lock file {path}: {error.strerror}") from error
    with file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            file.seek(0)
            raise AlreadyRunning(namespace, f"pid {file.read().strip() or 'unknown'}") from error
        file.truncate(0)
        file.write(str(os.getpid()))
        file.flush()
        yield
