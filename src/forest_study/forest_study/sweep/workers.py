"""A study's runs on all cores of this machine, or on a Dask cluster.

Runs go in batches, so that handing one over costs little beside it. Dask gives a batch to another worker when
its own dies. A batch that kills `distributed.scheduler.allowed-failures` workers is told as failed, and the
others go on.
"""

import contextlib
import math
import os
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from forest_study.closed_loop import loop_kernel
from forest_study.results import StudyError, require_llvm
from forest_study.sweep.design import Run
from forest_study.sweep.trials import KINDS

if TYPE_CHECKING:
    from distributed import Client

Row = dict[str, Any]
CALM = {"distributed.worker.profile.enabled": False, "distributed.admin.tick.interval": "500ms"}
"""Settings of a cluster of our own: its stacks looked at a hundred times a second cost 3 % of both cores."""


def batches(runs: Sequence[Run], workers: int, most: int) -> list[Sequence[Run]]:
    """Return runs in batches of so many at most, at least four for each worker where there are enough."""
    length = max(1, min(most, math.ceil(len(runs) / (4 * workers))))
    return [runs[k : k + length] for k in range(0, len(runs), length)]


def run_batch(kind: str, common: Mapping[str, Any], batch: Sequence[Run]) -> list[Row]:
    """Return the figures of each run; `error` says why one has none."""
    return [_run(kind, common, one) for one in batch]


def _run(kind: str, common: Mapping[str, Any], one: Run) -> Row:
    told = row(one)
    try:
        return told | KINDS[kind].figures({**common, **one.varied}, one.seed)
    except (StudyError, ArithmeticError, ValueError) as error:  # a path or a machine that cannot be, too
        return told | {"error": str(error)}


def row(one: Run) -> Row:
    """Return what a run is, as its row begins."""
    about = {"number": one.number, "combination": one.combination, "point": one.point, "seed": one.seed}
    return {**about, "error": None, **one.varied}


@contextlib.contextmanager
def cluster(scheduler: str | None, workers: int | None) -> "Iterator[Client]":
    """Give a client of Dask: of a scheduler, or of workers that live as long as it.

    Args:
        scheduler: its address, as tcp://host:8786; None: workers of our own, on loopback.
        workers: of our own; None: one for each core that this process may use.

    Raises:
        StudyError: Dask or LLVM is not installed, or the scheduler does not answer.
    """
    require_llvm("sweep")
    try:
        import dask
        from distributed import Client, LocalCluster
    except ImportError:
        raise StudyError(
            "sweep needs Dask, which is not installed: pip install 'forest-crane[sweep]'"
        ) from None
    loop_kernel.KERNEL.kernel()  # made once, here: workers of our own find it in its cache
    if scheduler is not None:
        try:
            found = Client(scheduler, timeout="3s")
        except (OSError, ValueError) as error:
            raise StudyError(f"no Dask scheduler answers at {scheduler}: {error}") from error
        with found:
            yield found
        return
    count = workers or len(os.sched_getaffinity(0))
    with (
        dask.config.set(CALM),
        LocalCluster(
            n_workers=count, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
        ) as own,
        Client(own) as client,
    ):
        yield client


def results(
    client: "Client", kind: str, common: Mapping[str, Any], todo: Sequence[Sequence[Run]]
) -> Iterator[list[Row]]:
    """Yield the rows of each batch as it ends, in any order."""
    from distributed import as_completed

    futures = {client.submit(run_batch, kind, common, batch, pure=False): batch for batch in todo}
    for future in as_completed(futures):
        batch = futures.pop(future)
        error = future.exception()
        yield future.result() if error is None else [row(one) | {"error": f"{error}"} for one in batch]
        future.release()
