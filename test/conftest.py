"""What tests of running nodes share: a domain of their own, processes that never outlive a test, waiting."""

from __future__ import annotations

import contextlib
import gc
import importlib
import itertools
import os
import random
import re
import signal
import socket
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

import hypothesis.configuration
import pytest
from hypothesis import HealthCheck, settings
from peer import Peer
from processes import ForkedNode, Process, Told

import forest_msgs_py

# The message packages' type support imports a parser that imports a deprecated module of Python's; elsewhere
# in the tests a deprecation is an error.
with warnings.catch_warnings(), contextlib.suppress(ImportError):
    warnings.simplefilter("ignore", DeprecationWarning)
    importlib.import_module("rosidl_generator_py")

DOMAINS = range(80, 102)
MET_S = 30.0  # at which a test fails rather than hangs; on a busy machine a node alone takes seconds to start

# Before the first participant of this process: the middleware reads them once.
os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
os.environ["PYTHONFAULTHANDLER"] = "1"
os.environ["FASTRTPS_DEFAULT_PROFILES_FILE"] = str(Path(forest_msgs_py.__file__).with_name("loopback.xml"))

# A suite that `nohup` or a batch system starts hands on that the hang-up is to be ignored.
signal.signal(signal.SIGHUP, signal.SIG_DFL)

# Properties draw from their own text, not by chance, and keep nothing between runs.
hypothesis.configuration.set_hypothesis_home_dir(Path(__file__).parents[1] / ".pytest_cache" / "hypothesis")
settings.register_profile(
    "suite",
    phases=[phase for phase in settings().phases if phase.name not in os.environ.get("WITHOUT_PHASES", "")],
    derandomize=True,
    deadline=None,
    database=None,
    max_examples=60,
    # Fixtures hold nothing that an example changes; the first example compiles and imports.
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
settings.load_profile("suite")


# A file with none of these fixtures has no live test: `-m live` need not import it.
LIVE = re.compile(r"\b((session_)?domain_id|ros_context|make_node|start_process|start_graph|peer|crane)\b")


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Pass over the files without live tests when nothing else is asked for."""
    is_test = collection_path.suffix == ".py" and collection_path.name.startswith("test_")
    only_live = config.option.markexpr == "live" and is_test
    return True if only_live and not LIVE.search(collection_path.read_text("utf-8")) else None


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, Any, Any]:
    """Look for garbage among what tests make, not among the 400 000 objects of modules and items."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_make_collect_report(collector: pytest.Collector) -> Generator[None, Any, Any]:
    """Have every second worker import the folders backwards: it finds files that another has compiled."""
    report = yield
    number = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    if isinstance(collector, pytest.Directory) and number % 2:
        report.result.reverse()
    return report


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the live tests, and run the files with most of them first, then the pages' examples.

    A file runs in one worker: the last one to begin should be short.
    """
    live = [item for item in items if _is_live(item)]
    for item in live:
        item.add_marker("live")
    unseen = {str(item.path) for item in live if not LIVE.search(item.path.read_text("utf-8"))}
    assert not unseen, f"live tests, but `-m live` passes over them: {unseen}"
    starts = Counter(item.path for item in live)
    items.sort(
        key=lambda item: (starts[item.path], item.path.parent.name == "docs", str(item.path)), reverse=True
    )


def _is_live(item: pytest.Item) -> bool:
    """Whether nodes run in it, which keep time with the computer's clock."""
    return bool({"domain_id", "session_domain_id"} & set(getattr(item, "fixturenames", ())))


_domains = itertools.cycle(random.Random(os.getpid()).sample(DOMAINS, len(DOMAINS)))


@contextlib.contextmanager
def claimed_domain() -> Iterator[int]:
    """A ROS domain that no other test run uses meanwhile, and this one has not used for long.

    The claim is an abstract socket: it reaches as far as loopback traffic does, and ends with this process.
    """
    for number in itertools.islice(_domains, len(DOMAINS)):
        claim = socket.socket(socket.AF_UNIX)
        try:
            claim.bind(f"\0forest-test-domain-{number}")
        except OSError:
            claim.close()
            continue
        with claim:
            yield number
        return
    pytest.fail(f"every ROS domain in {DOMAINS} is in use")


@pytest.fixture
def domain_id(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """A domain for one test; processes started later inherit it."""
    with claimed_domain() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield number


@pytest.fixture(scope="session")
def session_domain_id() -> Iterator[int]:
    """A domain for a fixture that serves many tests; whoever uses it hands it on."""
    with claimed_domain() as number:
        yield number


@pytest.fixture(scope="session")
def lockstep_domain_id() -> Iterator[int]:
    """A domain for nodes in lockstep: no clock hurries them, so their tests are not live."""
    with claimed_domain() as number:
        yield number


@pytest.fixture
def ros_context(domain_id: int) -> Iterator[Any]:
    """A running rclpy context in the test's own domain."""
    rclpy = pytest.importorskip("rclpy")
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain_id)
    yield context
    context.try_shutdown()


@pytest.fixture
def make_node(ros_context: Any) -> Iterator[Callable[..., Any]]:
    """Makes nodes in the test's domain that end with the test: one left over listens on in the next."""
    from rclpy.node import Node

    made: list[Any] = []

    def make(name: str, **options: Any) -> Any:
        made.append(Node(name, context=ros_context, **options))
        return made[-1]

    yield make
    for node in made:
        node.destroy_node()


@pytest.fixture
def start_process(tmp_path: Path) -> Iterator[Callable[..., Told]]:
    """Starts processes (``python=True``: arguments for this interpreter); none of them outlives the test.

    A module without further options is forked, not started anew.
    """
    started: list[Any] = []

    def start(argv: list[str], python: bool = True, **options: Any) -> Told:
        log = tmp_path / f"process_{len(started)}.log"
        if python and argv[0] == "-m" and not options:
            started.append(ForkedNode(argv[1], argv[2:], log))
        else:
            started.append(Process([sys.executable, *argv] if python else argv, log, **options))
        return started[-1]

    yield start
    for process in started:
        if process.poll() is None:
            process.stop()
    leftover = [process for process in started if process.leftover()]
    for process in leftover:
        process.kill_group()
    assert not leftover, [process.args for process in leftover]


@pytest.fixture
def wait_until() -> Callable[..., None]:
    """Waits for a condition, at most ``seconds``; spins an executor meanwhile if there is one."""

    def wait(predicate: Callable[[], Any], seconds: float = MET_S, executor: Any = None) -> None:
        deadline = time.monotonic() + seconds
        while not predicate():
            if time.monotonic() > deadline:
                pytest.fail(f"condition not met within {seconds} s")
            if executor is None:
                time.sleep(0.01)
            else:
                executor.spin_once(timeout_sec=0.01)

    return wait


@pytest.fixture
def peer(ros_context: Any, wait_until: Callable[..., None]) -> Iterator[Peer]:
    """The rest of the graph, as a node under test sees it."""
    friend = Peer(ros_context, wait_until)
    yield friend
    friend.close()
