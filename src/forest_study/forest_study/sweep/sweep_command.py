"""`forest-study sweep`: the runs of a study's file over all cores or a Dask cluster, resumable."""

import argparse
import sys
import time
from pathlib import Path

from forest_msgs_py.runtime.command_line import StatusLine, whole
from forest_study.results import write_json
from forest_study.sweep.design import runs, size
from forest_study.sweep.store import Store
from forest_study.sweep.study import Study, read_study
from forest_study.sweep.summary import draw, summary, table
from forest_study.sweep.trials import KINDS
from forest_study.sweep.workers import batches, cluster, results

EVERY = 1.0  # [s] between two words on progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's options."""
    parser.add_argument("study", type=Path, metavar="STUDY.yaml", help="study file: docs/how-to/sweep.md")
    text = "address of a Dask cluster, such as tcp://host:8786 (default: all cores of this machine)"
    parser.add_argument("--scheduler", metavar="ADDRESS", help=text)
    text = "processes on this machine (default: one per core)"
    parser.add_argument("--workers", type=whole(1, 1024), metavar="N", help=text)


def run(options: argparse.Namespace) -> int:
    """Run the command; return its exit code: 1 where a run failed.

    Raises:
        StudyError: the study's file, its directory or the cluster is not usable.
        OSError: the disk is full.
    """
    study = read_study(options.study)
    store = Store(options.out, study)
    run_the_rest(study, store, options.scheduler, options.workers)
    report = summary(study, store.finish())
    write_json(options.out / "summary.json", report)
    text = table(report)
    (options.out / "summary.md").write_text(text + "\n", encoding="utf-8")
    draw(report, options.out / "shares.png")
    print(text)
    print(f"  {store.whole}")
    return 1 if report["failed"] else 0


def run_the_rest(study: Study, store: Store, scheduler: str | None, workers: int | None) -> None:
    """Run what the store has no rows of; arguments as `workers.cluster`."""
    done, count = store.done(), size(study)
    if len(done) == count:
        return
    line, begun, before = StatusLine(sys.stdout), time.monotonic(), len(done)
    with cluster(scheduler, workers) as client:
        count_of = max(1, len(client.nthreads()))
        print(f"{count - before} runs of {count}, {count_of} workers; dashboard: {client.dashboard_link}")
        todo = batches(
            [one for one in runs(study) if one.number not in done], count_of, KINDS[study.kind].batch
        )
        told = begun
        for rows in results(client, study.kind, study.common, todo):
            store.add(rows)
            before, now = before + len(rows), time.monotonic()
            if now - told >= EVERY or before == count:
                told, rate = now, (before - len(done)) / (now - begun)
                line.show(f"{before} of {count}, {rate:.3g} a second, {(count - before) / rate:.0f} s left")
        line.end()
