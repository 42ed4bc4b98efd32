"""Which walk of each condition the page of a study shows."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from small_result import walk_result
from warpmuscle.results.result import write
from warpmuscle.sweep.study.measured import MeasuredRun, StudyResult
from warpmuscle.sweep.study.replay import replay_of, typical


def run(condition: float, cost: float, seed: int, walked: bool = True, series: str = "") -> MeasuredRun:
    own: Any = SimpleNamespace(name=f"{condition}, {seed}", seed=seed, axes={})
    return MeasuredRun(own, condition, series, walked, {"cost": cost}, file=Path(f"{seed}.h5"))


def study_of(*runs: MeasuredRun, reference: float = 1.0) -> StudyResult:
    study: Any = SimpleNamespace(reference=reference, title="a study")
    return StudyResult(study, runs, (), ())


def test_the_run_of_median_cost_stands_for_a_condition():
    costs = [(5.0, 1), (1.0, 2), (3.0, 3), (9.0, 4)]
    found = typical(study_of(*(run(1.0, cost, seed) for cost, seed in costs), run(0.5, 2.0, 7)))
    assert {condition: one.run.seed for condition, one in found.items()} == {1.0: 3, 0.5: 7}


def test_a_fall_stands_for_a_condition_only_where_none_walked():
    fell = [run(1.0, 1.0, 1, walked=False), run(1.0, 1.0, 2, walked=False), run(1.0, 8.0, 3)]
    assert typical(study_of(*fell))[1.0].run.seed == 3
    assert typical(study_of(*fell[:2]))[1.0].run.seed == 1


def test_of_many_conditions_there_are_the_ends_and_the_reference():
    runs = [run(float(k), 1.0, k) for k in range(10)] + [run(20.0, 1.0, 20, series="other")]
    shown = list(typical(study_of(*runs, reference=2.0)))
    assert (shown[0], shown[-1], len(shown)) == (0.0, 9.0, 4)
    assert 2.0 in shown


def test_runs_whose_files_cannot_be_read_are_left_out():
    assert replay_of(study_of(run(1.0, 1.0, 1)), {1.0: "strength 1"}) == ""


def test_a_run_that_diverged_at_once_is_left_out_beside_others(tmp_path: Path):
    walk = walk_result()
    none = replace(walk, replays=(walk.replays[0].window(100.0),))
    for seed, result in ((1, walk), (2, none)):
        write(tmp_path / f"{seed}.h5", result)
    walked, ended = (replace(run(condition, 1.0, seed), file=tmp_path / f"{seed}.h5")
                     for condition, seed in ((1.0, 1), (0.5, 2)))  # fmt: skip
    names = {1.0: "strong", 0.5: "weak"}
    shown = replay_of(study_of(walked, ended), names)
    assert "<iframe" in shown
    assert shown == replay_of(study_of(walked), names)
    assert replay_of(study_of(replace(ended, condition=1.0)), names) == ""
