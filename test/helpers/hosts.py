"""Hosts of a test: network namespaces of its own, with a switch or a slow link between them.

Such a host shares no network with another, and no memory (`ip netns exec` gives it mounts of its own).
"""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

OWN_MEMORY = 'mount -t tmpfs none /dev/shm && exec "$@"'
SLOW_LINK = str(Path(__file__).with_name("slow_link.py"))


def ip(*words: str) -> None:
    """Run the command `ip`."""
    subprocess.run(["ip", *words], check=True)


def reason() -> str:
    """Return why this process may not make hosts, "" if it may."""
    if os.geteuid() != 0 or shutil.which("ip") is None:
        return "needs root and the ip command to make network namespaces"
    name = f"forest-probe-{os.getpid()}"
    made = subprocess.run(["ip", "netns", "add", name], capture_output=True, text=True, check=False)
    if made.returncode == 0:
        ip("netns", "del", name)
    return made.stderr.strip()


@contextlib.contextmanager
def hosts(*names: str) -> Iterator[list[str]]:
    """Give namespaces without any link; the test is skipped where there can be none."""
    if why := reason():
        pytest.skip(why)
    made = [f"forest-{name}-{os.getpid()}" for name in names]
    try:
        for name in made:
            ip("netns", "add", name)
            ip("-n", name, "link", "set", "lo", "up")
        yield made
    finally:
        for name in made:
            subprocess.run(["ip", "netns", "del", name], check=False)


def switch(at: Sequence[str], addresses: Sequence[str]) -> None:
    """Join hosts, each at its address with length of the prefix, by a bridge in the first; it is `link0`."""
    ip("-n", at[0], "link", "add", "link0", "type", "bridge")
    for number, name in enumerate(at[1:]):
        ip("link", "add", f"port{number}", "netns", at[0], "type", "veth", "peer", "link0", "netns", name)
        ip("-n", at[0], "link", "set", f"port{number}", "master", "link0", "up")
    for name, address in zip(at, addresses, strict=True):
        ip("-n", name, "addr", "add", address, "dev", "link0")
        ip("-n", name, "link", "set", "link0", "up")


@contextlib.contextmanager
def slow_link(at: Sequence[str], addresses: Sequence[str], *options: str) -> Iterator[None]:
    """Join two hosts by a link that delays and loses, as the options of `slow_link.py` say; it is `link0`."""
    relay = subprocess.Popen([sys.executable, SLOW_LINK, *at, *options], stdout=subprocess.PIPE)
    try:
        assert relay.stdout is not None
        assert relay.stdout.readline() == b"up\n"
        for name, address in zip(at, addresses, strict=True):
            ip("-n", name, "addr", "add", address, "dev", "link0")
            ip("-n", name, "link", "set", "link0", "up")
        yield
    finally:
        relay.kill()
        relay.communicate()


def on(host: str, *command: str) -> list[str]:
    """Return the command that runs a command on a host."""
    return ["ip", "netns", "exec", host, "sh", "-c", OWN_MEMORY, "sh", *command]
