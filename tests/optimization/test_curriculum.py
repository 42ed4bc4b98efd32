"""Searches in stages: each goes on from the best of the one before, and all of them as if never interrupted."""

import dataclasses
import signal
import subprocess

import h5py
import numpy as np
import pytest
from msgspec.structs import replace as changed
from typer.testing import CliRunner

from child_signals import PROGRAM, running
from killing import killed_at
from patience import for_a_moment, ticking, until
from same_values import assert_same
from warpmuscle.cli.program import app
from warpmuscle.formats import load, toml
from warpmuscle.optimization import curriculum, evaluation, progress
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.resume import resume
from warpmuscle.optimization.stages import stage_seed
from warpmuscle.results.records import Result
from warpmuscle.results.result import read, write
from warpmuscle.scene import SearchStage
from warpmuscle.scene.parameters import start_values, substitute, with_values
from warpmuscle.scene.stage_scene import stage_scene
from warpmuscle.simulation.rollout import Rollout

SURVIVE = SearchStage("survive", {"torque": 0.5}, free=["controller.pd.*"], duration=0.1, candidates=9)
SPEED = SearchStage(
    "speed", {"speed": 5.0, "heading": 1.0}, {"com_height": 0.5}, strategy="random", population=4, candidates=10
)
EFFORT = SearchStage("effort", free=["controller.states.*.angle.*", "controller.states.0.time"], sigma=0.1)
CANDIDATES = 40
OPTIONS = {"seed": 5, "device": "cpu", "command": "test", "search": "cma", "population": 6}


@pytest.fixture(scope="module")
def scene():
    return changed(load("fwalk"), duration=0.15, stages=[SURVIVE, SPEED, EFFORT])


@pytest.fixture(scope="module")
def whole(scene) -> Result:
    return optimize(scene, CANDIDATES, **OPTIONS)


def in_stage(result: Result, number: int):
    """The candidates of a stage."""
    return result.evaluations.rows(result.evaluations.stage == number)


def test_stages_equal_searches_made_by_hand(scene, whole):
    plain = changed(scene, stages=[])

    def by_hand(values, number, states, pd, candidates, objective, **options):
        started, fixed = with_values(plain, values).controller, substitute(plain, values).controller
        controller = changed(fixed, states=(started if states else fixed).states, pd=(started if pd else fixed).pd)
        objective = changed(plain.objective, **objective)
        changes = {"duration": SURVIVE.duration, "objective": objective} if number == 0 else {"objective": objective}
        begun = changed(plain, controller=controller, **changes)
        return optimize(begun, candidates, stage_seed(5, number), "cpu", **options)

    cma = {"search": "cma", "population": 6}
    first = by_hand(start_values(plain), 0, False, True, 9, SURVIVE.objective, **cma)
    np.testing.assert_array_equal(in_stage(whole, 0).cost, first.evaluations.cost)
    values = in_stage(whole, 0).params[first.best.index]
    second = by_hand(values, 1, True, True, 10, SPEED.objective, search="random", population=4)
    np.testing.assert_array_equal(in_stage(whole, 1).cost, second.evaluations.cost)
    np.testing.assert_array_equal(in_stage(whole, 1).params, second.evaluations.params)
    names = scene.stages[2].free
    assert len(names) == 2
    values = second.best.params
    third = optimize(stage_scene(scene, 2, values), 21, stage_seed(5, 2), "cpu", sigma=0.1, **cma)
    np.testing.assert_array_equal(in_stage(whole, 2).cost, third.evaluations.cost)
    assert (whole.best.cost, whole.best.index) == (third.best.cost, third.best.index + 19)


def test_only_the_parameters_that_a_stage_frees_move_from_the_best_before(scene, whole):
    before = start_values(scene)
    for number, stage in enumerate(whole.searched.stages):
        mine = in_stage(whole, number)
        moved = np.any(mine.params != before, axis=0)
        assert {name for name, moves in zip(whole.parameters.name, moved, strict=True) if moves} <= set(stage.free)
        assert moved.sum() > 0.5 * len(stage.free)
        first = mine.rows(mine.generation == mine.generation[0])
        assert np.any(np.all(first.params == before, axis=1))
        before = mine.params[mine.cost.argmin()]
    assert set(whole.searched.stages[0].free) == {n for n in whole.parameters.name if n.startswith("controller.pd.")}


def test_best_is_that_of_the_last_stage_and_replayed_in_its_scene(scene, whole):
    last = in_stage(whole, 2)
    assert whole.best.cost == last.cost.min() > in_stage(whole, 0).cost.min()
    again = stage_scene(scene, 2, whole.best.params)
    rollout = Rollout(again, 1, "cpu")
    rollout.run()
    assert rollout.cost()[0] == whole.best.cost
    assert whole.replays[0].time[-1] == pytest.approx(scene.duration, abs=0.01)
    assert np.isnan(last.terms[:, whole.evaluations.term_names.index("speed")]).all()
    assert np.isfinite(in_stage(whole, 1).terms).all()


def test_file_has_each_stage_with_its_best_and_its_end(whole, tmp_path):
    write(tmp_path / "a.h5", whole)
    assert_same(read(tmp_path / "a.h5"), whole)
    with h5py.File(tmp_path / "a.h5") as file:
        stage, cost = file["evaluations/stage"][()], file["evaluations/cost"][()]
        assert [int(np.sum(stage == k)) for k in range(3)] == [9, 10, 21]
        assert np.all(np.diff(file["evaluations/generation"][()]) >= 0)
        assert np.all(np.diff(file["history/stage"][()]) >= 0)
        assert len({*zip(file["history/generation"][()], file["history/search"][()], strict=True)}) == 6
        for k, name in enumerate(("survive", "speed", "effort")):
            group = file[f"stages/{k}"]
            assert group.attrs["name"] == name
            assert group["best/cost"][()] == cost[stage == k].min() == cost[group["best/index"][()]]
        assert file["stages/0"].attrs["ended"] == "all candidates have been evaluated"
        assert (file["searches"].attrs["stage"], file["best/stage"][()]) == (2, 2)


def test_target_ends_a_stage_and_the_last_one_gets_what_it_left(scene):
    stages = [changed(SURVIVE, objective={"torque": 0.0, "fall": 1.0}, target=0.0, candidates=20), EFFORT]
    result = optimize(changed(scene, stages=stages), 30, **OPTIONS)
    assert result.searched.stages[0].ended == "the target is reached"
    assert [len(in_stage(result, k)) for k in (0, 1)] == [7, 23]
    assert result.searched.ended == "all candidates have been evaluated"


def test_target_of_the_search_is_that_of_the_last_stage(scene, whole):
    first, last = in_stage(whole, 0).cost.min(), in_stage(whole, 2)
    target = float(np.sort(last.cost)[1])
    result = optimize(scene, 1000, target=target, **OPTIONS)
    assert first < target
    assert [stage.ended for stage in result.searched.stages] == ["all candidates have been evaluated"] * 2 + [""]
    assert result.searched.ended == "the target is reached"
    assert result.best.cost <= target


def test_time_ends_a_stage_which_is_then_over_for_good(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(progress, "time", ticking(0.01))
    stages = [changed(SPEED, candidates=10**6, until=0.3), EFFORT]
    path = tmp_path / "a.h5"
    short = changed(scene, stages=stages)

    def interrupt(progress):
        if progress.stage == 1 and progress.done > done[0] + 20:
            raise KeyboardInterrupt
        if progress.stage == 0:
            done[0] = progress.done

    done = [0]
    part = optimize(short, 2 * 10**6, output=path, progress=interrupt, **OPTIONS)
    assert part.searched.stages[0].ended == "the time is up"
    result = resume(path, 30)
    assert len(in_stage(result, 0)) == len(in_stage(part, 0)) > 4
    assert len(in_stage(result, 1)) == len(in_stage(part, 1)) + 30
    assert result.searched.stages[0].ended == "the time is up"


def test_progress_tells_the_stage_and_never_runs_backwards(scene):
    seen = []
    optimize(scene, CANDIDATES, progress=seen.append, **OPTIONS)
    for name in ("stage", "done", "generation", "fraction", "simulated"):
        assert [getattr(p, name) for p in seen] == sorted(getattr(p, name) for p in seen), name
    assert list(dict.fromkeys((p.stage, p.stage_name, p.stages) for p in seen)) == [
        (0, "survive", 3), (1, "speed", 3), (2, "effort", 3),
    ]  # fmt: skip
    assert (seen[-1].done, seen[-1].candidates) == (CANDIDATES, CANDIDATES)


def test_two_halves_equal_the_whole_and_more_goes_to_the_last_stage(scene, whole, tmp_path):
    path = tmp_path / "a.h5"
    part = optimize(scene, 22, output=path, **OPTIONS)
    assert [len(in_stage(part, k)) for k in range(3)] == [9, 10, 3]
    assert_same(resume(path, 18, threads=1), whole)
    assert_same(read(path), whole)
    more = resume(path, 11)
    assert [len(in_stage(more, k)) for k in range(3)] == [9, 10, 32]
    assert_same(more.evaluations.rows(slice(CANDIDATES)), whole.evaluations)


@pytest.mark.parametrize("moment", [3, 9, 12, 19, 20, 30])
def test_interrupted_search_goes_on_bit_for_bit_from_any_stage(moment, scene, whole, tmp_path, monkeypatch):
    def interrupt(progress):
        if progress.done >= moment:
            raise KeyboardInterrupt

    path = tmp_path / "a.h5"
    monkeypatch.setattr(evaluation, "CPU_BATCH", 2)
    part = optimize(scene, CANDIDATES, output=path, progress=interrupt, **OPTIONS)
    assert part.searched.ended == "interrupted"
    assert moment <= len(part.evaluations) < CANDIDATES
    assert part.best.cost == in_stage(part, part.evaluations.stage[-1]).cost.min()
    recalled = []
    assert_same(resume(path, progress=lambda p: recalled.append(p.recalled)), whole)
    assert recalled[-1] == len(part.evaluations)
    write(tmp_path / "b.h5", whole)
    assert path.read_bytes() == (tmp_path / "b.h5").read_bytes()
    resume(path)
    assert path.read_bytes() == (tmp_path / "b.h5").read_bytes()


def test_interrupt_between_two_stages_undoes_nothing(scene, whole, tmp_path, monkeypatch):
    def interrupted(rollout_scene, options, seed):
        if seed == stage_seed(5, 1):
            raise KeyboardInterrupt
        return searches_of(rollout_scene, options, seed)

    path, searches_of = tmp_path / "a.h5", curriculum.searches_of
    with monkeypatch.context() as patch:
        patch.setattr(curriculum, "searches_of", interrupted)
        part = optimize(scene, CANDIDATES, output=path, **OPTIONS)
    assert (len(part.evaluations), part.searched.ended, part.searched.stage) == (9, "interrupted", 0)
    assert_same(resume(path), whole)


@pytest.mark.long
def test_kill_at_any_write_in_any_stage_loses_nothing(scene, whole, tmp_path):
    path = tmp_path / "a.h5"
    for moment in range(3, 1000, 5):
        for leftover in tmp_path.iterdir():
            leftover.unlink()
        with killed_at(moment) as killed:
            optimize(scene, CANDIDATES, output=path, **OPTIONS)
        if not killed:
            break
        if not path.exists():
            assert moment <= 6  # the journal comes first
            continue
        assert_same(resume(path), whole)
        assert_same(read(path), whole)
        assert [other.name for other in tmp_path.iterdir()] == ["a.h5"]
    else:
        pytest.fail("never came to its end")


@pytest.mark.long
def test_kill_of_the_process_loses_nothing(scene, tmp_path):
    stages = [changed(stage, candidates=None) for stage in scene.stages]
    scene = changed(scene, stages=stages)
    toml.write(scene, tmp_path / "a.toml")
    arguments = ["optimize", str(tmp_path / "a.toml"), "--search", "cma", "--population", "6", "--candidates", "900"]
    path = tmp_path / "a.h5"
    for more in ([*arguments, "--device", "cpu", "-o", str(path)], ["optimize", "--resume", str(path)]):
        with running([*PROGRAM, *more], stderr=subprocess.DEVNULL) as process:
            until(path.exists, process)  # a quick machine may have reached the end by the time of the kill
            for_a_moment(np.random.default_rng().uniform(0.1, 0.8))
            process.send_signal(signal.SIGKILL)
    result = resume(path)
    again = optimize(scene, 900, 1, "cpu", search="cma", population=6)
    assert_same(dataclasses.replace(result, command=""), again)


def test_scene_with_the_best_values_keeps_its_stages(scene, whole, tmp_path):
    write(tmp_path / "a.h5", whole)
    done = CliRunner().invoke(app, ["apply", str(tmp_path / "a.h5"), "-o", str(tmp_path / "best.toml")])
    assert done.exit_code == 0, done.exception
    best = toml.read(tmp_path / "best.toml")
    assert best.stages == scene.stages
    np.testing.assert_array_equal(start_values(best), whole.best.params)
