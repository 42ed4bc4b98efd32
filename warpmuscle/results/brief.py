"""Results of searches without most of their candidates: what a study needs of each of a thousand.

A search of 3000 candidates has a megabyte of them. The first one, the best one, and what each generation brought say
how it went and what it found; so does the motion of the best one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpmuscle.core.errors import ResultError
from warpmuscle.core.plain_text import number_of
from warpmuscle.results.records import Best, Result

ALL, BEST = "all", "best"  # candidates that the result of a run of a sweep keeps


def brief(result: Result) -> Result:
    """A result of a search that has ended with the first and the best of its candidates only.

    Nor does it have what its searches know, from which they would go on: they cannot, without their candidates. One
    without candidates, or with stages, of which each has candidates of its own, stays as it is.
    """
    evaluations, best, searched = result.evaluations, result.best, result.searched
    if evaluations is None or best is None or searched is None or searched.stages or result.is_brief:
        return result
    rows = np.unique([0, best.index])
    return replace(
        result, evaluations=evaluations.rows(rows), best=Best(best.params, best.cost, len(rows) - 1),
        searched=replace(searched, states=(), evaluated=len(evaluations)),
    )  # fmt: skip


def check_complete(result: Result, what: str) -> None:
    """Raise ResultError if a result holds only some of its candidates; `what` cannot be done then."""
    if result.is_brief:
        count = number_of(result.evaluated, "candidate")
        raise ResultError(f'holds only the best of its {count}: {what}; keep = "all" keeps them')
