"""Runs side by side, in windows smaller than the sweep, are as alone, and so is what journals of killed ones begin."""

from pathlib import Path

import numpy as np
import pytest

from small_sweep import assert_same_file
from warpmuscle.optimization.optimize import optimize
from warpmuscle.results.result import read, write
from warpmuscle.results.sweeps import read_sweep
from warpmuscle.sweep import board, lockstep
from warpmuscle.sweep.plan import read as plan_of
from warpmuscle.sweep.run import sweep

TEXT = """
scene = "fwalk"
[set]
duration = 0.05
"objective.torque" = 0
[search]
population = 5
candidates = 13
[[grid]]
seed = [1, 2, 3]
"character.bodies.torso.mass" = [20, 30]
[[grid]]
"search.strategy" = ["random", "cma"]
"search.population" = [4, 20]
"""


@pytest.fixture
def small_windows(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("LEAST_WINDOW", "MOST_WINDOW"):
        monkeypatch.setattr(lockstep, name, 4)
    monkeypatch.setattr(lockstep, "REPLAY_BYTES", 1)


def test_runs_of_several_windows_are_as_alone_to_the_last_bit(tmp_path: Path, small_windows: None):
    (tmp_path / "a.toml").write_text(TEXT)
    assert sweep(tmp_path / "a.toml", tmp_path / "a.h5", device="cpu").failed == {}
    for run in plan_of(tmp_path / "a.toml").runs:
        o = run.options
        alone = optimize(run.scene, o.candidates, run.seed, "cpu", search=o.strategy, population=o.population)
        assert "speed" in alone.evaluations.term_names  # of the usual objective, since the scene weighs nothing
        write(tmp_path / "alone.h5", alone)
        found = read(tmp_path / "a.h5", run.name)
        np.testing.assert_array_equal(found.evaluations.params, alone.evaluations.params)
        np.testing.assert_array_equal(found.replays[0].com, alone.replays[0].com)
        assert_same_file(tmp_path / "a.sweep" / f"{run.name}.h5", tmp_path / "alone.h5")


@pytest.mark.parametrize("keep", ["all", "best"])
def test_window_that_was_interrupted_goes_on_as_if_it_had_not_been(
    tmp_path: Path, small_windows: None, monkeypatch: pytest.MonkeyPatch, keep: str
):
    monkeypatch.setattr(board, "TELL_EVERY", 0.0)
    for name in ("whole", "parts"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "a.toml").write_text(f'keep = "{keep}"{TEXT}')
    sweep(tmp_path / "whole" / "a.toml", tmp_path / "whole" / "a.h5", device="cpu")
    output, at = tmp_path / "parts" / "a.h5", [20, 60, 90]

    def interrupt(progress):
        if at and progress.evaluated >= at[0]:
            at.pop(0)
            raise KeyboardInterrupt

    while at:
        before = len(at)
        with pytest.raises(KeyboardInterrupt):
            sweep(tmp_path / "parts" / "a.toml", output, device="cpu", progress=interrupt)
        assert len(at) < before
        assert list((tmp_path / "parts" / "a.sweep").glob("*.rounds"))
    told: list[int] = []
    sweep(tmp_path / "parts" / "a.toml", output, device="cpu", progress=lambda now: told.append(now.evaluated))
    assert told[0] > 0
    assert told == sorted(told)  # what is known from before is counted from the beginning
    assert_same_file(output, tmp_path / "whole" / "a.h5")
    assert not list((tmp_path / "parts" / "a.sweep").glob("*.rounds"))


@pytest.mark.parametrize("keep", ["all", "best"])
def test_runs_that_keep_only_their_best_find_the_same(tmp_path: Path, small_windows: None, keep: str):
    (tmp_path / "a.toml").write_text(f'keep = "{keep}"{TEXT}')
    done = sweep(tmp_path / "a.toml", tmp_path / "a.h5", device="cpu")
    table = read_sweep(tmp_path / "a.h5")
    rows = len(table.candidates()["cost"].values)
    for run in plan_of(tmp_path / "a.toml").runs:
        o = run.options
        alone = optimize(run.scene, o.candidates, run.seed, "cpu", search=o.strategy, population=o.population)
        found = table.run(run.name)
        assert (found.evaluated, found.is_brief) == (len(alone.evaluations), keep == "best")
        np.testing.assert_array_equal(found.best.params, alone.best.params)
        np.testing.assert_array_equal(found.searched.history.best, alone.searched.history.best)
        np.testing.assert_array_equal(found.replays[0].com, alone.replays[0].com)
    assert table.columns["evaluated"].values.tolist() == [run.candidates for run in plan_of(tmp_path / "a.toml").runs]
    assert (rows <= 2 * len(table)) == (keep == "best")
    states = done.folder.states(done.manifest)  # by what is known of finished runs, and by the files themselves
    for path in done.folder.path.glob("*.finished"):
        path.unlink()
    (done.folder.path / "index.json").unlink()
    assert done.folder.states(done.manifest) == states
    assert [state.evaluated for state in states] == [state.candidates for state in states]
