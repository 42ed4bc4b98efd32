"""A sweep whose points are chosen in rounds: some, then more where the results of those before say so.

What has been chosen is kept in the folder of the sweep before it runs: a command that goes on has the same points.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import msgspec
import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.files import replace_file, unreadable
from warpmuscle.core.plain_text import number_of
from warpmuscle.sweep.folder import Folder, Manifest, RunState
from warpmuscle.sweep.plan import Plan
from warpmuscle.sweep.refinement.choice import next_points
from warpmuscle.sweep.samples import POINT

CHOSEN = "points.json"
Done = TypeVar("Done")


def in_rounds(
    plan: Plan, folder: Folder, once: Callable[[Plan, bool], Done], manifest_of: Callable[[Done], Manifest]
) -> Done:  # fmt: skip
    """Run a sweep round by round, from what has been chosen before.

    Args:
        once: runs all of a plan that has not ended; True for the last one, of which all is gathered.

    Raises:
        Error: what has been chosen cannot be read or kept, or nothing came of any point.
    """
    refinement = plan.refinement
    assert refinement is not None
    chosen = chosen_points(folder.path, refinement.dimensions)
    while True:
        known = refinement.with_chosen(chosen)
        left = refinement.count - len(known)
        own = refinement.grown(chosen)
        done = once(own, left <= 0)
        if left <= 0:
            return done
        values = values_of(own, folder.states(manifest_of(done)), len(known))
        if not np.isfinite(values).any():
            raise Error("nothing has come of any point, so that none can be chosen after them")
        more = next_points(known, values, min(refinement.batch, left), refinement.seed)
        chosen = np.concatenate([chosen, more])
        replace_file(folder.path / CHOSEN, msgspec.json.encode(chosen.tolist()))


def chosen_points(folder: Path, dimensions: int) -> Floats:
    """Points (n, d) of the unit cube that have been chosen in a sweep; none if there is no such file.

    Raises:
        ResultError: the file is damaged, or of other axes.
    """
    path = folder / CHOSEN
    try:
        found = msgspec.json.decode(path.read_bytes(), type=list[list[float]])
    except FileNotFoundError:
        return np.zeros((0, dimensions))
    except (OSError, msgspec.DecodeError) as error:
        reason = unreadable(error) if isinstance(error, OSError) else "is damaged"
        raise ResultError(f"{path}: {reason}; remove {folder} to begin anew") from None
    if any(len(point) != dimensions or not all(0.0 <= x <= 1.0 for x in point) for point in found):
        raise ResultError(
            f"{path}: these are not points of {number_of(dimensions, 'axis')}; take another --output, "
            f"or remove {folder}"
        )
    return np.array(found, dtype=np.float64).reshape(-1, dimensions)


def values_of(plan: Plan, states: list[RunState], count: int) -> Floats:
    """Least costs (count, m) of points under m conditions, means over seeds; NaN where there is none."""
    refinement = plan.refinement
    assert refinement is not None
    best = {state.name: state.best for state in states}
    places: dict[str, int] = {}
    costs: dict[tuple[int, int], list[float]] = {}
    for run in plan.runs:
        others = {name: value for name, value in run.axes.items() if name not in (POINT, "seed", *refinement.axes)}
        condition = places.setdefault(repr(sorted(others.items())), len(places))
        costs.setdefault((int(run.axes[POINT]), condition), []).append(best.get(run.name, np.inf))
    found = np.full((count, len(places)), np.nan)
    for place, own in costs.items():
        mean = float(np.mean(own))
        found[place] = mean if np.isfinite(mean) else np.nan
    return found
