"""Candidates and generations of one stage as rows of the whole search, and back."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from dataclasses import replace as changed

import numpy as np
from numpy.typing import NDArray

from warpmuscle.core.array_types import Floats
from warpmuscle.optimization.evaluation import OtherCandidates
from warpmuscle.results.records import Evaluations, History


@dataclass(frozen=True)
class StageRows:
    """Turns the rows of a stage, whose search knows p of P parameters, t of T terms, and generations from 0 on."""

    stage: int
    first: int  # number of the stage's first generation in the whole search
    values: Floats  # (P,), of the parameters that it does not free
    columns: NDArray[np.intp]  # (p,), of those that it does
    term_names: tuple[str, ...]  # T names
    terms: NDArray[np.intp]  # (t,)

    def of_search(self, part: Evaluations) -> Evaluations:
        """Candidates of the stage with all parameters and terms; terms that it has not are not numbers."""
        count = len(part)
        params, terms = np.tile(self.values, (count, 1)), np.full((count, len(self.term_names)), np.nan)
        params[:, self.columns], terms[:, self.terms] = part.params, part.terms
        generation, stage = part.generation + np.int32(self.first), np.full(count, self.stage, dtype=np.int32)
        return changed(part, params=params, terms=terms, term_names=self.term_names, generation=generation, stage=stage)

    def part(self, whole: Evaluations) -> Evaluations:
        """Candidates as the search of the stage knows them.

        Raises:
            OtherCandidates: they have other terms.
        """
        if whole.term_names != self.term_names:
            raise OtherCandidates(self.first)
        names = tuple(whole.term_names[index] for index in self.terms)
        return changed(
            whole, params=whole.params[:, self.columns], terms=whole.terms[:, self.terms], term_names=names,
            generation=whole.generation - np.int32(self.first), stage=np.zeros_like(whole.stage),
        )  # fmt: skip

    def search_history(self, part: History) -> History:
        """Generations of the stage, numbered as in the whole search."""
        return changed(part, generation=part.generation + self.first, stage=np.full_like(part.stage, self.stage))

    def part_history(self, whole: History) -> History:
        """Those of all generations that are the stage's, numbered from 0."""
        mine = history_of(whole, self.stage)
        return changed(mine, generation=mine.generation - self.first)


def joined_history(parts: Sequence[History]) -> History:
    """The generations of stages one behind the other; at least one part."""
    return History(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(History)})


def history_of(whole: History, stage: int) -> History:
    """The generations of a stage."""
    return History(**{field.name: getattr(whole, field.name)[whole.stage == stage] for field in fields(History)})
