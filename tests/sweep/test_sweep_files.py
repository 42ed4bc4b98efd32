"""Sweeps on this machine: what they leave behind, and that they go on where they were, whatever has ended them."""

import io
import os
import signal
import subprocess
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from child_signals import PROGRAM, running
from described import assert_described
from patience import PATIENCE, until
from small_disk import disk_of
from small_sweep import RUNS, assert_same_file, small_sweep
from warpmuscle.cli.program import app
from warpmuscle.core.errors import Error, ResultError
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.results.journal import journal_path
from warpmuscle.results.result import read
from warpmuscle.sweep import board as board_module
from warpmuscle.sweep import folder as folder_module
from warpmuscle.sweep import local
from warpmuscle.sweep import run as run_module
from warpmuscle.sweep.folder import Folder
from warpmuscle.sweep.plan import read as plan_of
from warpmuscle.sweep.run import sweep
from warpmuscle.sweep.status import sweep_status


@pytest.fixture(scope="module")
def done(tmp_path_factory) -> Path:
    """Output of a sweep that nothing has disturbed."""
    folder = tmp_path_factory.mktemp("done")
    sweep(small_sweep(folder), folder / "small.h5", device="cpu", command="test")
    return folder / "small.h5"


def test_every_run_is_the_optimisation_alone(done):
    with h5py.File(done) as file:
        names = list(file["runs"])
    assert len(names) == RUNS
    name = "seed=2,torso.mass=30,torque=2"
    scene = load("fwalk")
    scene.duration, scene.character.bodies["torso"].mass, scene.objective.torque = 0.1, 30.0, 2.0
    alone = optimize(scene, 20, 2, "cpu", search="cma", population=6)
    result = read(done, run=name)
    np.testing.assert_array_equal(result.evaluations.params, alone.evaluations.params)
    np.testing.assert_array_equal(result.evaluations.cost, alone.evaluations.cost)
    np.testing.assert_array_equal(result.replays[0].com, alone.replays[0].com)
    assert result.scene == alone.scene


def test_output_has_a_table_and_the_candidates_of_all_runs(done):
    assert_described(done)
    with h5py.File(done) as file:
        table, whole = file["table"], file["all"]
        names = table["run"].asstr()[()].tolist()
        assert names == list(file["runs"])
        first = 0
        for row, name in enumerate(names):
            assert file["runs"][name][()].tobytes() == Folder.of(done).result(name).read_bytes()
            run = h5py.File(io.BytesIO(file["runs"][name][()].tobytes()))
            count = len(run["evaluations/cost"])
            part = slice(first, first + count)
            for column in ("cost", "status", "end_time", "search", "generation", "params", "terms"):
                np.testing.assert_array_equal(whole[column][part], run[f"evaluations/{column}"][()])
            assert np.all(whole["run"][part] == row)
            assert table["best_cost"][row] == run["best/cost"][()] == whole["cost"][part].min()
            best = run["best/index"][()]
            np.testing.assert_array_equal(table["best_params"][row], run["evaluations/params"][best])
            np.testing.assert_array_equal(table["best_terms"][row], run["evaluations/terms"][best])
            assert f"seed={table['axes/seed'][row]:g},torso.mass={table['axes/torso.mass'][row]:g}" in name
            first += count
        assert first == len(whole["cost"]) == 20 * RUNS
        assert {name.decode() for name in table["ended"][()]} == {"all candidates have been evaluated"}
        assert whole["status"].attrs["COMPLETED"] == Status.COMPLETED
        assert file.attrs["ended"]
        assert {"began", "host", "warpmuscle_version"} <= set(file.attrs)


def test_one_run_is_read_by_its_name(done, tmp_path):
    such = r"such as 'seed=1,torso.mass=20,torque=1'"
    with pytest.raises(ResultError, match=rf"a sweep of 8 runs; name one of them \(--run, or run= in Python\), {such}"):
        read(done)
    with pytest.raises(
        ResultError, match=r"no run is called 'seed=1,torso.mass=20,torque=9'; did you mean 'seed=1,torso.mass=20"
    ):
        read(done, run="seed=1,torso.mass=20,torque=9")
    with pytest.raises(ResultError, match="not of a sweep; it has no run 'x'"):
        read(Folder.of(done).result("seed=1,torso.mass=20,torque=1"), run="x")


def test_same_sweep_again_changes_nothing(done):
    before = {path: path.read_bytes() for path in (done, *Folder.of(done).path.iterdir())}
    sweep(done.with_name("small.toml"), done, device="cpu", command="test")
    assert {path: path.read_bytes() for path in (done, *Folder.of(done).path.iterdir())} == before


def started(folder: Path, *more: str) -> AbstractContextManager[subprocess.Popen]:
    arguments = ["sweep", "small.toml", "--device", "cpu", "-o", "small.h5", *more]
    return running([*PROGRAM, *arguments], cwd=folder, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def wait_for_generations(folder: Path, more: int, process: subprocess.Popen) -> int:
    """Wait until so many more candidates have been evaluated; how many there are then."""
    seen: list[int] = []

    def came() -> bool:
        if (folder / "small.sweep" / "sweep.json").exists():
            seen.append(sweep_status(folder / "small.toml").evaluated)
        return bool(seen) and seen[-1] >= seen[0] + more

    until(came, process)
    return seen[-1]


MANY = 300  # candidates of a run that is killed, before it ends


@pytest.mark.long
@pytest.mark.parametrize("keep", ["all", "best"])
def test_kill_at_any_moment_loses_nothing_and_the_same_command_goes_on(tmp_path, monkeypatch, keep):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "whole").mkdir()
    small_sweep(tmp_path, candidates=MANY, duration=0.2, keep=keep)
    small_sweep(tmp_path / "whole", candidates=MANY, duration=0.2, keep=keep)
    evaluated = 0
    for more in (180, 300):
        with started(tmp_path) as process:
            seen = wait_for_generations(tmp_path, more, process)
            status = sweep_status("small.toml")
            assert status.busy
            assert "running" in {status.word(run) for run in status.runs}
            process.send_signal(signal.SIGKILL)
        status = sweep_status("small.toml")
        assert not status.busy
        assert "stopped; the same command goes on" in {status.word(run) for run in status.runs}
        assert status.evaluated >= seen > evaluated
        evaluated = status.evaluated
    assert evaluated < MANY * RUNS
    with started(tmp_path) as process:
        out, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, errors
    assert f"small: {RUNS} of {RUNS} runs done, {MANY * RUNS} candidates; best: " in out
    assert not list((tmp_path / "small.sweep").glob("*.journal")) + list((tmp_path / "small.sweep").glob(".*.h5.*"))
    with started(tmp_path / "whole") as process:
        process.communicate(timeout=PATIENCE)
    assert_same_file(tmp_path / "small.h5", tmp_path / "whole" / "small.h5")


@pytest.mark.long
def test_interrupt_keeps_what_was_evaluated(tmp_path, done):
    def interrupt(progress):
        if progress.evaluated > 100:
            raise KeyboardInterrupt

    output = tmp_path / "small.h5"
    with pytest.raises(KeyboardInterrupt):
        sweep(small_sweep(tmp_path), output, device="cpu", command="test", progress=interrupt)
    status = sweep_status(output)
    assert 100 < status.evaluated < 20 * RUNS
    assert status.ended == 0
    sweep(tmp_path / "small.toml", output, device="cpu", command="test")
    assert_same_file(output, done)


@pytest.mark.long
def test_full_disk_is_one_line_for_each_run_and_nothing_is_lost(tmp_path, done):
    full = []

    def fill(progress):
        if not full and progress.evaluated > 100:
            full.append(disk.enter_context(disk_of(1_000)))

    output = tmp_path / "small.h5"
    with ExitStack() as disk, pytest.raises(ResultError) as caught:
        sweep(small_sweep(tmp_path), output, device="cpu", command="test", progress=fill)
    assert "small.h5: cannot be written: file too large" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert sweep_status(output).evaluated > 100
    result = sweep(tmp_path / "small.toml", output, device="cpu", command="test")
    assert (result.failed, result.gathered) == ({}, RUNS)
    assert_same_file(output, done)


def test_sweep_or_scene_that_has_changed_is_refused(tmp_path, done):
    folder = done.parent
    file = small_sweep(folder, candidates=21)
    try:
        with pytest.raises(
            ResultError, match=r"small.toml: this sweep.* has changed .*run 'seed=1,torso.mass=20,torque=1' is"
        ):
            sweep(file, done, device="cpu")
        file.write_text(file.read_text().replace("seed = [1, 2]", "seed = [1]").replace("= 21", "= 20"))
        with pytest.raises(ResultError, match=r"run 'seed=2,torso.mass=20,torque=1' is gone"):
            sweep(file, done, device="cpu")
        file.write_text("# with a comment\n" + small_sweep(folder).read_text())
        sweep(file, done, device="cpu", command="test")  # the runs are the same
    finally:
        small_sweep(folder)


def test_further_values_and_seeds_run_alone_and_the_file_is_that_of_all_at_once(tmp_path, monkeypatch):
    monkeypatch.setattr(local, "run_in_lockstep", counted := Counted(local.run_in_lockstep))
    for folder in ("all", "parts"):
        (tmp_path / folder).mkdir()
    text = small_sweep(tmp_path / "all").read_text()
    text = text.replace('torque" = [1, 2]', 'torque" = [1, 3]').replace("[20, 30]", "[20, 30, 25]")
    (tmp_path / "all" / "small.toml").write_text(text := text.replace("seed = [1, 2]", "seed = [7, 1, 2]"))
    sweep(tmp_path / "all" / "small.toml", tmp_path / "all" / "small.h5", device="cpu", command="test")
    assert len(counted.seen) == 18
    counted.seen.clear()
    parts, output = tmp_path / "parts" / "small.toml", tmp_path / "parts" / "small.h5"
    parts.write_text(text.replace("[7, 1, 2]", "[1, 2]").replace("[20, 30, 25]", "[20]"))
    sweep(parts, output, device="cpu", command="test")
    assert len(counted.seen) == 4
    began = read_attribute(output, "began")

    def interrupt(progress):
        if progress.evaluated > 4 * 20 + 100:
            raise KeyboardInterrupt

    parts.write_text(text)
    with pytest.raises(KeyboardInterrupt):
        sweep(parts, output, device="cpu", command="test", progress=interrupt)
    assert sweep_status(output).evaluated > 4 * 20
    counted.seen.clear()
    result = sweep(parts, output, device="cpu", command="test")
    assert (result.failed, result.gathered) == ({}, 18)
    assert_same_file(output, tmp_path / "all" / "small.h5")
    assert read_attribute(output, "began") == began


class Counted:
    """A function that remembers the names of the tasks that it was given."""

    def __init__(self, function):
        self.function, self.seen = function, []

    def __call__(self, *arguments, **options):
        self.seen += [task.name for task in arguments[0]]
        return self.function(*arguments, **options)


def read_attribute(path: Path, name: str) -> str:
    with h5py.File(path) as file:
        return str(file.attrs[name])


def test_finished_sweep_is_neither_looked_into_nor_gathered_again(done, monkeypatch):
    def refuse(*arguments, **options):
        raise AssertionError("this looks into the file of a run")

    monkeypatch.setattr(folder_module, "glance", refuse)
    monkeypatch.setattr(run_module, "gather", refuse)
    assert sweep(done.with_name("small.toml"), done, device="cpu", command="test").gathered == RUNS


@pytest.mark.parametrize("kind", ["text", "result", "other sweep"])
def test_file_that_is_not_of_this_sweep_is_not_replaced(kind, done, tmp_path):
    file, output = small_sweep(tmp_path), tmp_path / "small.h5"
    if kind == "text":
        output.write_text("notes")
    elif kind == "result":
        output.write_bytes(Folder.of(done).result("seed=1,torso.mass=20,torque=1").read_bytes())
    else:
        output.write_bytes(done.read_bytes())
        file.write_text('name = "another"\n' + file.read_text())
    before = output.read_bytes()
    with pytest.raises(Error, match=r"small.h5: .*would be replaced.*name another --output, or move it out of the way"):
        sweep(file, output, device="cpu")
    assert output.read_bytes() == before
    assert not (tmp_path / "small.sweep").exists()


def test_run_that_cannot_be_simulated_fails_alone(tmp_path):
    file = tmp_path / "a.toml"
    file.write_text(
        'scene = "fwalk"\n[set]\nduration = 0.1\n[search]\nstrategy = "random"\ncandidates = 4\npopulation = 2\n'
        '[[run]]\nname = "good"\n[[run]]\nname = "bad"\ntracking.file = "missing.h5"\nobjective.tracking = 1\n'
    )
    done = CliRunner().invoke(app, ["sweep", str(file), "-o", str(tmp_path / "a.h5"), "--device", "cpu"])
    assert isinstance(done.exception, Error)
    assert "1 of 2 runs failed; bad: missing.h5: no such file" in str(done.exception)
    assert read(tmp_path / "a.h5", run="good").best is not None
    status = sweep_status(tmp_path / "a.h5")
    assert [status.word(run) for run in status.runs] == ["done: all candidates have been evaluated", "waiting"]


STAGED = """
scene = "fwalk"
seed = 4
[set]
duration = 0.1
stages = [
    { name = "first", candidates = 0.5, objective = { torque = 3.0 } },
    { name = "second", free = ["controller.pd.*"] },
]
[search]
strategy = "cma"
population = 5
candidates = 30
[grid]
stages.0.objective.torque = [1, 2]
"""


def test_search_in_stages_can_be_swept_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.setattr(board_module, "TELL_EVERY", 0.0)

    def interrupt(progress):
        if progress.evaluated >= 12:
            raise KeyboardInterrupt

    file, output = tmp_path / "a.toml", tmp_path / "a.h5"
    file.write_text(STAGED)
    with pytest.raises(KeyboardInterrupt):
        sweep(file, output, device="cpu", progress=interrupt)
    assert 0 < sweep_status(output).evaluated < 30
    assert sweep(file, output, device="cpu").failed == {}
    runs = plan_of(file).runs
    for run in runs:
        alone = optimize(run.scene, 30, 4, "cpu", search="cma", population=5)
        result = read(output, run=run.name)
        np.testing.assert_array_equal(result.evaluations.cost, alone.evaluations.cost)
        state = next(state for state in sweep_status(output).runs if state.name == run.name)
        assert (state.evaluated, state.candidates, state.best) == (30, 30, alone.best.cost)
    with h5py.File(output) as out:
        assert np.unique(out["all/stage"]).tolist() == [0, 1]
        assert out["table/best_cost"][0] == read(output, run=runs[0].name).best.cost


def test_two_processes_cannot_work_on_one_sweep(done):
    with Folder.of(done).at_work(), pytest.raises(ResultError, match="another process is at work on this sweep"):
        sweep(done.with_name("small.toml"), done, device="cpu")


def test_status_is_told_by_any_of_the_files_and_not_without_them(done, tmp_path, monkeypatch):
    monkeypatch.chdir(done.parent)
    for file in ("small.toml", "small.h5", "small.sweep"):
        out = CliRunner().invoke(app, ["sweep", "--status", file]).output
        assert "small: 8 of 8 runs done, 160 candidates; best: seed=" in out
        assert len(out.splitlines()) == 10
    with pytest.raises(Error, match="no sweep of it has begun here"):
        sweep_status(tmp_path / "b.toml")


def test_damaged_run_is_computed_anew_once_it_is_removed(tmp_path, done):
    import shutil

    shutil.copytree(done.parent, tmp_path / "copy")
    output = tmp_path / "copy" / "small.h5"
    damaged = Folder.of(output).result("seed=1,torso.mass=20,torque=1")
    damaged.write_bytes(b"rubbish")
    result = sweep(output.with_suffix(".toml"), output, device="cpu", command="test")
    assert list(result.failed) == ["seed=1,torso.mass=20,torque=1"]
    assert "not an HDF5 file, or damaged" in result.failed["seed=1,torso.mass=20,torque=1"]
    assert result.failure.endswith("or damaged; remove this file, and the run is computed anew")
    os.unlink(damaged)
    assert not journal_path(damaged).exists()
    sweep(output.with_suffix(".toml"), output, device="cpu", command="test")
    assert_same_file(output, done)
