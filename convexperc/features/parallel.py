"""The same work on several items side by side, on the cores that the process may use."""

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def available_cores() -> int:
    """Return how many cores this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def side_by_side(work: Callable[[Item], Result], items: Sequence[Item], workers: int) -> list[Result]:
    """Return ``[work(item) for item in items]``, computed by the caller and up to ``workers - 1`` threads.

    Each takes successive items. The threads have ended when the call returns, so that none outlives it, is
    missing after a fork, or keeps the interpreter from its end.

    Raises
    ------
    Exception
        What `work` raised at the first item, in their order, of those at which it raised.
    """

    def each(part: Sequence[Item]) -> list[Result]:
        return [work(item) for item in part]

    workers = min(workers, len(items))
    if workers < 2:
        return each(items)
    ends = [len(items) * part // workers for part in range(workers + 1)]
    own, *others = (items[start:end] for start, end in pairwise(ends))
    with ThreadPoolExecutor(workers - 1) as pool:
        running = [pool.submit(each, part) for part in others]
        return [*each(own), *(result for part in running for result in part.result())]
