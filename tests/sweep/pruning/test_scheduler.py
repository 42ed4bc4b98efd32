"""Who goes on of runs that compete: the better part after each number of candidates, whatever the order of work."""

import numpy as np

from warpmuscle.sweep.pruning.rule import Rule
from warpmuscle.sweep.pruning.scheduler import Referee

RULE = Rule((0.25, 0.5), 0.5, ("seed",))


class Walker:
    """A run of 8 candidates with given costs, two a generation."""

    def __init__(self, costs: list[float], rivals: str = "all", done: int = 0):
        self.every, self.rivals, self.candidates, self.done, self.ended = costs, rivals, 8, done, ""

    def costs(self):
        return np.array(self.every[: self.done])

    def stop(self, reason: str) -> None:
        self.ended = reason


def played(runs: list[Walker], at_once: int = 99, ended: dict | None = None) -> list[int]:
    """Candidates of each run in the end; so many get theirs in a round, others wait."""
    referee = Referee(RULE, runs, ended or {})
    waiting = set(range(len(runs)))
    while waiting:
        verdict = referee.judge(sorted(waiting))
        assert verdict.go or verdict.stop
        assert not verdict.go & verdict.stop
        waiting -= verdict.stop
        for number in sorted(verdict.go)[:at_once]:
            runs[number].done += 2
        waiting -= {number for number in waiting if runs[number].done >= 8}
    return [run.done for run in runs]


def costs_of(*best: float) -> list[list[float]]:
    return [[one + 1.0, one, *[one - 0.1] * 6] for one in best]


def test_half_of_the_rivals_go_on_after_each_part():
    runs = [Walker(costs) for costs in costs_of(4.0, 1.0, 3.0, 2.0)]
    assert played(runs) == [2, 8, 2, 4]
    assert runs[0].ended == "pruned after 2 candidates: 4 of 4 by its cost"
    assert runs[3].ended == "pruned after 4 candidates: 2 of 2 by its cost"


def test_the_order_of_work_and_what_was_done_before_change_nothing():
    costs = costs_of(4.0, 1.0, 3.0, 2.0, 5.0)
    wanted = played([Walker(one) for one in costs])
    assert played([Walker(one) for one in costs], at_once=1) == wanted
    resumed = [Walker(one, done=done) for one, done in zip(costs, (2, 6, 0, 4, 2), strict=True)]
    assert played(resumed) == wanted


def test_what_comes_after_the_number_of_candidates_does_not_count():
    late = Walker([9.0, 9.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0], done=4)  # as after an interruption: far ahead by now
    assert played([late, *map(Walker, costs_of(1.0, 2.0, 3.0))])[0] == 4
    assert late.ended == "pruned after 2 candidates: 4 of 4 by its cost"


def test_groups_do_not_compete_with_each_other():
    runs = [Walker(costs, rivals) for costs, rivals in zip(costs_of(1.0, 2.0, 8.0, 9.0), "aabb", strict=True)]
    assert played(runs) == [8, 2, 8, 2]


def test_rivals_that_ended_earlier_count():
    ended = {"all": [np.array(costs) for costs in costs_of(0.5, 0.6)]}
    assert played([Walker(costs) for costs in costs_of(1.0, 2.0)], ended=ended) == [2, 2]


def test_of_equals_the_first_goes_on():
    assert played([Walker(costs) for costs in costs_of(1.0, 1.0)]) == [8, 2]
