"""Searches that are killed or interrupted go on as if they had not been, to the last bit."""

import signal
import subprocess
import warnings
from contextlib import ExitStack
from pathlib import Path

import h5py
import msgspec
import numpy as np
import pytest
from typer.testing import CliRunner

from child_signals import PROGRAM, running
from killing import Killed, killed_at
from patience import for_a_moment, until
from same_values import assert_same
from small_disk import disk_of
from warpmuscle.cli.program import app
from warpmuscle.core.errors import Error, ResultError, ResumeWarning
from warpmuscle.core.machine import this_machine
from warpmuscle.formats import load
from warpmuscle.optimization import evaluation
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.resume import resume
from warpmuscle.results import checkpoint
from warpmuscle.results.journal import journal_path
from warpmuscle.results.records import Result
from warpmuscle.results.result import read, write

CANDIDATES = 36
STRATEGIES = {
    "random": {"search": "random", "population": 12},
    "cma": {"search": "cma", "population": 6, "searches": 2},
    "nlopt": {"search": "nlopt:LN_BOBYQA", "searches": 3},
}


@pytest.fixture(scope="module")
def scene():
    return msgspec.structs.replace(load("fwalk"), duration=0.1)


@pytest.fixture(scope="module", params=STRATEGIES)
def options(request):
    return {"seed": 5, "device": "cpu", "command": "test", **STRATEGIES[request.param]}


@pytest.fixture(scope="module")
def uninterrupted(scene, options) -> Result:
    return optimize(scene, CANDIDATES, **options)


def only_file(path: Path) -> bool:
    return [other.name for other in path.parent.iterdir()] == [path.name]


def test_two_halves_equal_the_whole(scene, options, uninterrupted, tmp_path):
    path = tmp_path / "a.h5"
    optimize(scene, CANDIDATES // 2 - 1, output=path, **options)
    result = resume(path, CANDIDATES // 2 + 1, threads=1)
    assert_same(result, uninterrupted)
    assert_same(read(path), uninterrupted)
    assert only_file(path)


def test_islands_go_on_through_an_exchange_as_if_they_had_not_been_interrupted(scene, tmp_path):
    """Two islands, seven generations; the worse one gives way after five."""
    short, path = msgspec.structs.replace(scene, duration=0.02), tmp_path / "a.h5"
    options = {"seed": 2, "device": "cpu", "command": "test", "search": "islands", "population": 200}
    whole = optimize(short, 1401, **options)
    assert whole.searched.states[0]["means"].shape[0] == 2
    optimize(short, 901, output=path, **options)
    assert_same(resume(path, 500, threads=1), whole)


def test_random_search_goes_on_with_the_candidates_that_it_would_have_had(scene, tmp_path, monkeypatch):
    monkeypatch.setattr(evaluation, "_recordable", lambda trials: 1000)  # as on a GPU
    whole = optimize(scene, 20, 5, "cpu", search="random")
    optimize(scene, 8, 5, "cpu", search="random", output=tmp_path / "a.h5")
    result = resume(tmp_path / "a.h5", 12)
    assert whole.searched.options.population == 20
    assert result.searched.options.population == 8
    np.testing.assert_array_equal(result.evaluations.params, whole.evaluations.params)
    np.testing.assert_array_equal(result.evaluations.cost, whole.evaluations.cost)
    np.testing.assert_array_equal(result.replays[0].com, whole.replays[0].com)


def test_a_search_goes_on_for_some_time_with_any_number_of_candidates(scene, tmp_path):
    optimize(scene, 4, output=tmp_path / "a.h5", device="cpu")
    result = resume(tmp_path / "a.h5", until=0.5)
    assert result.evaluations is not None
    assert len(result.evaluations.cost) > 4


def test_kill_at_any_write_loses_nothing_but_the_generation_in_progress(
    scene, options, uninterrupted, tmp_path, monkeypatch
):
    monkeypatch.setattr(checkpoint, "SOONEST", 0.0)  # so that the file is among what is written
    path = tmp_path / "a.h5"
    for moment in (*range(1, 10), *range(10, 2000, 47)):
        for leftover in tmp_path.iterdir():
            leftover.unlink()
        with killed_at(moment) as killed:
            optimize(scene, CANDIDATES, output=path, **options)
        if not killed:
            break
        if not path.exists():
            assert moment <= 6  # the journal comes first
            continue
        assert read(path).searched is not None
        result = resume(path)
        assert_same(result, uninterrupted)
        assert only_file(path)
    else:
        pytest.fail("never came to its end")


def test_interrupted_generation_is_completed(scene, options, uninterrupted, tmp_path, monkeypatch):
    def interrupt(progress):
        if progress.done > CANDIDATES // 2:
            raise KeyboardInterrupt

    path = tmp_path / "a.h5"
    monkeypatch.setattr(evaluation, "CPU_BATCH", 2)
    part = optimize(scene, CANDIDATES, output=path, progress=interrupt, **options)
    assert CANDIDATES // 2 < len(part.evaluations) < CANDIDATES
    assert part.searched.ended == "interrupted"
    assert_same(resume(path), uninterrupted)


def test_interrupt_while_a_search_is_brought_back_changes_nothing(scene, tmp_path):
    def interrupt(progress):
        raise KeyboardInterrupt

    path = tmp_path / "a.h5"
    optimize(scene, 20, device="cpu", output=path)
    content = path.read_bytes()
    with pytest.raises(Error, match="its file is unchanged"):
        resume(path, 10, progress=interrupt)
    assert path.read_bytes() == content
    assert len(resume(path, 10).evaluations) == 30


def test_search_that_has_come_to_its_end_stays_as_it_is(scene, tmp_path):
    path = tmp_path / "a.h5"
    optimize(scene, 20, device="cpu", output=path)
    content = path.read_bytes()
    resume(path)
    assert path.read_bytes() == content


def test_a_file_with_less_of_the_motion_is_written_once_and_what_is_returned_has_all(scene, tmp_path, monkeypatch):
    path, written = tmp_path / "a.h5", []
    plain = checkpoint.write
    monkeypatch.setattr(checkpoint, "write", lambda at, result: (written.append(result), plain(at, result)))
    less = {"quantities": ["com"], "single": True}
    result = optimize(scene, 4, device="cpu", search="random", output=path, **less)
    assert [one.replays[0].missing == () for one in written if one.replays] == [False]
    assert result.replays[0].missing == ()
    with h5py.File(path) as file:
        assert file["replay/0"].attrs["quantities"] == "time, com"
        assert file["replay/0/com"].dtype == np.float32
    again = resume(path, 2, quantities=["com_velocity"])
    assert again.replays[0].missing == ()
    with h5py.File(path) as file:
        assert file["replay/0"].attrs["quantities"] == "time, com_velocity"
    with pytest.raises(Error, match="no quantity is called 'con'; did you mean 'com'"):
        optimize(scene, 4, device="cpu", output=tmp_path / "b.h5", quantities=["con"])
    assert only_file(path)


def test_kill_of_the_process_loses_nothing(tmp_path):
    many = "1000000"  # more than any machine evaluates before it is killed
    arguments = ["optimize", "fwalk", "--duration", "0.2", "--search", "cma", "--candidates", many, "--seed", "4"]
    path, evaluated = tmp_path / "a.h5", []
    rng = np.random.default_rng()

    def size(file: Path) -> int:
        return file.stat().st_size if file.exists() else 0

    for more in ([*arguments, "-o", str(path)], *[["optimize", "--resume", str(path)]] * 2):
        before = size(journal_path(path))
        with running([*PROGRAM, *more], stderr=subprocess.DEVNULL) as process:
            until(lambda before=before: size(journal_path(path)) != before and path.exists(), process)
            for_a_moment(rng.uniform(0.0, 0.9))
            process.send_signal(signal.SIGKILL)
        with h5py.File(path) as file:
            assert file.attrs["format"] == "warpmuscle"
        evaluated.append(len(read(path).evaluations))
    assert evaluated == sorted(evaluated)
    result = resume(path, 40)
    whole = optimize(
        msgspec.structs.replace(load("fwalk"), duration=0.2), len(result.evaluations), 4, "cpu", search="cma"
    )
    assert len(result.evaluations) > evaluated[-1]
    assert_same(result.evaluations, whole.evaluations)


@pytest.mark.parametrize("share", [-1.0, 1e9], ids=["journal", "file"])
def test_full_disk_is_one_line_and_nothing_is_lost(share, scene, tmp_path, monkeypatch):
    def fill(progress):
        if not full:
            full.append(disk.enter_context(disk_of(8_000)))  # the start has been written

    path, full = tmp_path / "a.h5", []
    options = {"seed": 5, "device": "cpu", **STRATEGIES["cma"]}
    monkeypatch.setattr(checkpoint, "SHARE", share)
    monkeypatch.setattr(checkpoint, "SOONEST", 0.0)
    with ExitStack() as disk, pytest.raises(ResultError) as caught:
        optimize(scene, CANDIDATES, output=path, progress=fill, **options)
    assert "cannot be written: file too large; what was evaluated is kept" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert len(read(path).evaluations) == 0
    assert_same(resume(path), optimize(scene, CANDIDATES, **options))
    assert only_file(path)


def test_other_candidates_than_before_are_refused(scene, options, tmp_path):
    path = tmp_path / "a.h5"
    optimize(scene, CANDIDATES // 2, output=path, **options)
    content = path.read_bytes()
    for name, row in {"history/asks_crc32": 0, "evaluations/params": (9, 0)}.items():
        with h5py.File(path, "a") as file:
            file[name][row] = file[name][row] + 1
        with pytest.raises(ResultError, match=r"cannot be continued here: generation \d+ .* made by python"):
            resume(path, 10)
        path.write_bytes(content)


@pytest.mark.parametrize("count", [CANDIDATES // 2, CANDIDATES // 2 - 1], ids=["whole", "part"])
def test_search_goes_on_on_another_machine_and_says_so(count, scene, options, tmp_path):
    path = tmp_path / "a.h5"
    optimize(scene, count, output=path, **options)
    asked_elsewhere(path, 1e-9)
    before = read(path)
    with pytest.warns(ResumeWarning, match=r"a.h5: began on an abacus with pebbles; on .* it goes on") as told:
        result = resume(path, 12)
    (said,) = (one for one in told if one.category is ResumeWarning)  # others may be of files left open elsewhere
    assert "\n" not in str(said.message)
    assert rows_of(before.evaluations) <= rows_of(result.evaluations)
    assert len(result.evaluations) == count + 12
    assert result.machine == this_machine()
    assert only_file(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = resume(path, 12)
    whole = again.evaluations.rows(slice(count + 12))
    assert_same(whole, result.evaluations)


def test_covariance_search_follows_what_was_evaluated_where_rounding_led_it_far_away(scene, tmp_path):
    """As happens after some generations, since directions that the covariance does not tell apart are arbitrary."""
    path = tmp_path / "a.h5"
    optimize(scene, 60, 5, "cpu", search="cma", population=6, output=path)
    asked_elsewhere(path, 0.05)
    before = read(path)
    with pytest.warns(ResumeWarning):
        result = resume(path, 12)
    assert rows_of(before.evaluations) <= rows_of(result.evaluations)
    mean = result.parameters.min + result.searched.states[0]["mean"] * (result.parameters.max - result.parameters.min)
    near = np.abs(result.evaluations.params[-12:] - mean) / (result.parameters.max - result.parameters.min)
    assert np.isfinite(result.evaluations.cost).all()
    assert near.max() < 1.0


def test_kill_on_the_other_machine_leaves_a_file_that_goes_on_there(scene, tmp_path, monkeypatch):
    path = tmp_path / "a.h5"
    optimize(scene, 30, 5, "cpu", search="cma", population=6, output=path)
    asked_elsewhere(path, 1e-9)
    with monkeypatch.context() as patch:
        patch.setattr(checkpoint.Checkpoint, "finish", lambda *_: (_ for _ in ()).throw(Killed))
        with pytest.warns(ResumeWarning), pytest.raises(Killed):
            resume(path, 12)
    assert read(path).machine == this_machine()
    assert len(resume(path, 6).evaluations) == 48


def test_a_search_of_another_version_goes_on_and_says_that_costs_may_count_otherwise(scene, tmp_path):
    path = tmp_path / "a.h5"
    optimize(scene, 12, 5, "cpu", population=6, output=path)
    with h5py.File(path, "a") as file:
        file.attrs["warpmuscle_version"] = "0.0.1"
    with pytest.warns(ResumeWarning, match=r"a.h5: was begun by warpmuscle 0.0.1; this is .*need not compare") as told:
        assert len(resume(path, 6).evaluations) == 18
    assert [one.category for one in told].count(ResumeWarning) == 1


def asked_elsewhere(path, moved):
    """Have the file's candidates as another machine may have asked for them, in units of each parameter's interval."""
    with h5py.File(path, "a") as file:
        file.attrs["processor"], file.attrs["blas"] = "an abacus", "pebbles"
        width = file["parameters/max"][()] - file["parameters/min"][()]
        rows = np.flatnonzero(file["evaluations/search"][()] >= 0)
        noise = np.random.default_rng(0).uniform(-moved, moved, size=(len(rows), len(width)))
        params = file["evaluations/params"][()]
        params[rows] = np.clip(params[rows] + noise * width, file["parameters/min"][()], file["parameters/max"][()])
        file["evaluations/params"][...] = params
        file["history/asks_crc32"][...] = 1


def rows_of(evaluations):
    """Candidates with their costs; those of a generation that was completed may have others between them."""
    return {(*params, cost) for params, cost in zip(evaluations.params.tolist(), evaluations.cost, strict=True)}


def test_files_that_hold_no_search_are_refused(scene, tmp_path):
    path = tmp_path / "a.h5"
    with pytest.raises(ResultError, match="no such file"):
        resume(path)
    path.write_text("hello")
    with pytest.raises(ResultError, match="not an HDF5 file"):
        resume(path)
    path.unlink()
    result = optimize(scene, 4, device="cpu")
    write(path, Result(result.scene, "cpu", "", 0, result.parameters))
    with pytest.raises(ResultError, match="holds no search"):
        resume(path)
    assert only_file(path)


def test_interrupted_search_is_not_overwritten(scene, tmp_path, monkeypatch):
    path = tmp_path / "a.h5"
    with monkeypatch.context() as patch:
        patch.setattr(checkpoint.Checkpoint, "finish", lambda *_: (_ for _ in ()).throw(Killed))
        with pytest.raises(Killed):
            optimize(scene, 8, device="cpu", output=path)
    with pytest.raises(ResultError, match="interrupted search; continue it with --resume"):
        optimize(scene, 8, device="cpu", output=path)
    assert len(resume(path).evaluations) == 8


def test_interrupt_before_anything_has_ended_leaves_a_file_to_begin_from(scene, tmp_path):
    def interrupt(progress):
        raise KeyboardInterrupt

    path = tmp_path / "a.h5"
    with pytest.raises(Error, match="nothing to keep"):
        optimize(scene, 8, device="cpu", output=path, progress=interrupt)
    assert only_file(path)
    assert_same(resume(path), optimize(scene, 8, device="cpu"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--resume", "a.h5", "fwalk"], "scene cannot be given with --resume"),
        (["--resume", "a.h5", "--seed", "2"], "--seed cannot be given with --resume"),
        (["--resume", "a.h5", "--time-step", "0.001"], "--time-step cannot be given with --resume"),
        (["--resume", "a.h5", "--candidates", "20"], "a.h5: no such file"),
        ([], "a scene, or --resume and a file"),
        (["fwalk", "--until", "soon"], "'soon' is not a time such as 90s"),
        (["fwalk", "--until", "0"], "'0' is not a time"),
    ],
)
def test_requests_that_contradict_a_resumed_search_are_clear_errors(arguments, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(Error, match=message):
        CliRunner().invoke(app, ["optimize", *arguments], catch_exceptions=False)
    assert not list(tmp_path.iterdir())


def test_command_line_begins_and_goes_on(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options = ["--duration", "0.1", "--search", "cma", "--searches", "2", "--population", "5", "--until", "1h30m"]
    begun = CliRunner().invoke(app, ["optimize", "fwalk", "--candidates", "21", "--device", "cpu", *options])
    assert begun.exit_code == 0, begun.exception
    gone_on = CliRunner().invoke(app, ["optimize", "--resume", "fwalk.h5", "--candidates", "10"])
    assert gone_on.exit_code == 0
    ended = CliRunner().invoke(app, ["optimize", "--resume", "fwalk.h5"])
    assert ["nothing was left to do" in done.output for done in (begun, gone_on, ended)] == [False, False, True]
    result = read("fwalk.h5")
    assert len(result.evaluations) == result.searched.options.candidates == 31
    assert result.searched.options.until == 5400.0
    assert len(result.command.splitlines()) == 3
