"""What is to be done for many runs, by several processes of this machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import TypeVar

SHARE = 24  # tasks of a process at least: it takes as long to start, 3 s of a core, as to measure a dozen runs

Task = TypeVar("Task")
Done = TypeVar("Done")


def in_processes(processes: int, work: Callable[[Task], Done], tasks: Sequence[Task]) -> Iterator[Done]:
    """What the work makes of each task, in order.

    Args:
        processes: at most so many, of which each has `SHARE` tasks at least; for fewer, this one does it.
        work: a function of a module, or such a one with some arguments given.
    """
    count = min(processes, len(tasks) // SHARE)
    if count < 2:
        yield from map(work, tasks)
        return
    with ProcessPoolExecutor(count, get_context("spawn")) as pool:
        yield from pool.map(work, tasks, chunksize=SHARE // 6)
