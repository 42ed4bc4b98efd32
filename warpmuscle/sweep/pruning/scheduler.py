"""Who goes on of runs that go side by side, and who waits until its rivals have come as far."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.plain_text import number_of
from warpmuscle.sweep.pruning.rule import Rule

PRUNED = "pruned"  # begins the reason why such a run has ended


class Rival(Protocol):
    """A run that competes."""

    rivals: str  # what those have in common that compete
    candidates: int  # in all

    @property
    def done(self) -> int:
        """Candidates so far."""
        ...

    def costs(self) -> Floats:
        """Costs of its candidates so far, in order."""
        ...

    def stop(self, reason: str) -> None:
        """Let it end where it is."""
        ...


class Verdict(NamedTuple):
    """Numbers of runs that wait for their next candidates: those that get them, and those that end."""

    go: set[int]
    stop: set[int]


class Referee:
    """Compares runs by their least costs after the same numbers of candidates, however far each has come.

    So it decides the same before and after an interruption, and on any device.
    """

    def __init__(self, rule: Rule, runs: Sequence[Rival], ended: Mapping[str, Sequence[Floats]]) -> None:
        """Begin.

        Args:
            runs: side by side. ended: costs of rivals of theirs that ended earlier and were not pruned, by what they
                have in common.
        """
        self._rule, self._runs, self._ended = rule, runs, ended
        self._groups: dict[str, list[int]] = {}
        for number, run in enumerate(runs):
            self._groups.setdefault(run.rivals, []).append(number)
        self._level = dict.fromkeys(self._groups, 0)
        self._out: set[int] = set()

    def judge(self, waiting: Sequence[int]) -> Verdict:
        """Who of the runs that wait gets candidates, and who ends; the others wait on."""
        here, go, stop = set(waiting), set[int](), set[int]()
        for key, members in self._groups.items():
            alive = [number for number in members if number in here]
            if not alive:
                continue
            rungs = self._rule.rungs(self._runs[members[0]].candidates)
            while alive and self._level[key] < len(rungs):
                rung = rungs[self._level[key]]
                if any(self._runs[number].done < rung for number in alive):
                    break
                losers = self._losers(key, rung, alive, [n for n in members if n not in self._out and n not in stop])
                stop |= losers
                alive = [number for number in alive if number not in losers]
                self._level[key] += 1
            level = self._level[key]
            go |= {n for n in alive if level == len(rungs) or self._runs[n].done < rungs[level]}
        self._out |= stop
        return Verdict(go, stop)

    def _losers(self, key: str, rung: int, alive: Sequence[int], rivals_here: Sequence[int]) -> set[int]:
        """Those that are behind after so many candidates, told to end; all rivals but pruned ones count."""
        best = {number: _least(self._runs[number].costs(), rung) for number in rivals_here}
        rivals = [*best.values(), *(_least(own, rung) for own in self._ended.get(key, ()))]
        kept = max(math.ceil(self._rule.keep * len(rivals)), 1)
        losers = set()
        for number in alive:  # who began earlier is before an equal one
            ahead = sum(other < best[number] or (other == best[number] and mate < number)
                        for mate, other in best.items())  # fmt: skip
            ahead += sum(other < best[number] for other in rivals[len(best) :])
            if ahead >= kept:
                self._runs[number].stop(
                    f"{PRUNED} after {number_of(rung, 'candidate')}: {ahead + 1} of {len(rivals)} by its cost"
                )
                losers.add(number)
        return losers


def _least(costs: Floats, rung: int) -> float:
    return float(np.min(costs[:rung], initial=np.inf))
