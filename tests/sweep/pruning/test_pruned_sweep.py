"""A sweep whose runs compete: those that go on are as without pruning, after an interruption and with seeds added."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import Error, SceneError
from warpmuscle.results.result import read
from warpmuscle.sweep import lockstep
from warpmuscle.sweep.lockstep import windows
from warpmuscle.sweep.plan import read as plan_of
from warpmuscle.sweep.run import sweep

TEXT = """
scene = "fwalk"
[set]
duration = 0.05
[search]
strategy = "random"
population = 4
candidates = 16
[grid]
seed = [{seeds}]
"character.bodies.torso.mass" = [20, 30]
{more}
"""
PRUNE = '[prune]\nafter = [0.25, 0.5]\nkeep = 0.5\namong = ["seed"]'


@pytest.fixture(autouse=True)
def small_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("LEAST_WINDOW", "MOST_WINDOW"):
        monkeypatch.setattr(lockstep, name, 2)


def swept(folder: Path, seeds: str = "1, 2, 3, 4", more: str = PRUNE, progress=None) -> dict[str, tuple]:
    """Why each run has ended, its candidates and their costs."""
    folder.mkdir(exist_ok=True)
    (folder / "a.toml").write_text(TEXT.format(seeds=seeds, more=more))
    result = sweep(folder / "a.toml", folder / "a.h5", device="cpu", progress=progress)
    assert result.failed == {}
    runs = {run.name: read(folder / "a.h5", run.name) for run in plan_of(folder / "a.toml").runs}
    return {name: (one.searched.ended, one.evaluations.params, one.evaluations.cost) for name, one in runs.items()}


def same(one: dict[str, tuple], other: dict[str, tuple]) -> None:
    assert one.keys() == other.keys()
    for name, (ended, params, costs) in one.items():
        assert other[name][0] == ended
        np.testing.assert_array_equal(other[name][1], params)
        np.testing.assert_array_equal(other[name][2], costs)


def test_runs_that_are_behind_stop_and_the_others_are_as_without_pruning(tmp_path: Path):
    whole, pruned = swept(tmp_path / "whole", more=""), swept(tmp_path / "pruned")
    for mass in (20, 30):
        mine = [name for name in pruned if name.endswith(f"={mass}")]
        assert sorted(len(pruned[name][2]) for name in mine) == [4, 4, 8, 16]
        (last,) = (name for name in mine if len(pruned[name][2]) == 16)
        same({last: whole[last]}, {last: pruned[last]})
        first = sorted(mine, key=lambda name: whole[name][2][:4].min())
        for name in first[2:]:
            assert pruned[name][0].startswith("pruned after 4 candidates")
            np.testing.assert_array_equal(pruned[name][2], whole[name][2][:4])
    again = sweep(tmp_path / "pruned" / "a.toml", tmp_path / "pruned" / "a.h5", device="cpu")
    assert again.gathered == 8


def test_an_interrupted_sweep_stops_the_same_runs(tmp_path: Path):
    wanted, at = swept(tmp_path / "whole"), [6, 26, 50]

    def interrupt(progress):
        if at and progress.evaluated >= at[0]:
            at.pop(0)
            raise KeyboardInterrupt

    while at:
        with pytest.raises(KeyboardInterrupt):
            swept(tmp_path / "parts", progress=interrupt)
    same(wanted, swept(tmp_path / "parts"))


def test_seeds_that_are_added_compete_with_those_that_went_on(tmp_path: Path):
    before = swept(tmp_path / "a", seeds="1, 2")
    after = swept(tmp_path / "a", seeds="1, 2, 3, 4")
    same(before, {name: after[name] for name in before})
    assert all(len(one[2]) in (4, 8, 16) for one in after.values())


def test_competing_runs_go_side_by_side_whatever_the_window():
    assert windows(["a", "b", "a", "b", "c"], 2) == [[0, 2], [1, 3], [4]]
    assert windows(["a"] * 5, 2) == [[0, 1, 2, 3, 4]]
    assert windows([""] * 5, 2) == [[0, 1], [2, 3], [4]]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("[prune]\nafter = [0.5, 0.25]", r"a.toml:13: prune.after: takes parts"),
        ("[prune]\nafter = []", r"prune.after: takes parts"),
        ("[prune]\nafter = [1.0]", r"prune.after: takes parts"),
        ("[prune]\nkeep = 0", r"prune.keep: the part that goes on is between 0 and 1, not 0"),
        ("[prune]\nkeep = nan", r"prune.keep"),
        ('[prune]\namong = ["sead"]', r"prune.among.*no axis is called 'sead'; did you mean 'seed'"),
        ("[prune]\nwhen = 1", r"when"),
        ("[prune]\n[training]\nuntil = 5", r"prune: trainings run one after the other"),
        ('[prune]\n[study]\ntitle = "a"', r"prune: a study compares searches that have ended"),
    ],
)
def test_tables_that_cannot_be_are_refused_in_a_line(tmp_path: Path, more: str, message: str):
    (tmp_path / "a.toml").write_text(TEXT.format(seeds="1, 2", more=more))
    with pytest.raises(SceneError, match=message) as caught:
        plan_of(tmp_path / "a.toml")
    assert "\n" not in str(caught.value)


def test_parts_of_a_sweep_do_not_compete(tmp_path: Path):
    (tmp_path / "a.toml").write_text(TEXT.format(seeds="1, 2", more=PRUNE))
    with pytest.raises(Error, match="runs that compete go side by side on one machine"):
        sweep(tmp_path / "a.toml", tmp_path / "a.h5", device="cpu", part="1/2")
