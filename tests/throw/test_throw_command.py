"""The command `throw`: what is refused before anything is fitted, what is said, and how a missed goal ends."""

import itertools
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

from warpmuscle.cli.program import app
from warpmuscle.cli.throw.goal import exit_code
from warpmuscle.core.errors import Error
from warpmuscle.results.result import read
from warpmuscle.throw import fit, job, signal_search, strength, synthesis
from warpmuscle.throw.fit import Settings

TIME = np.arange(0.0, 1.501, 0.01)
FEW = tuple(replace(way, population=8) for way in signal_search.WAYS)  # candidates of each way to search for a throw


@pytest.fixture
def motion(tmp_path: Path) -> Path:
    """A throw of an arm, without what the trunk and the shoulder do."""
    return written(tmp_path / "m.csv")


def written(path: Path, noise: float = 0.0) -> Path:
    phase = 2.0 * np.pi * TIME / 1.5
    angles = np.stack([60.0 - 30.0 * np.cos(phase), 60.0 + 20.0 * np.sin(phase), 10.0 * np.sin(phase)], axis=1)
    angles += noise * np.random.default_rng(0).normal(size=angles.shape)
    header = "time_s,shoulder_deg,elbow_deg,wrist_deg"
    np.savetxt(path, np.column_stack([TIME, angles]), delimiter=",", header=header, comments="")
    return path


@pytest.fixture
def nothing_fitted(monkeypatch: pytest.MonkeyPatch) -> None:
    def fit(*_: Any, **__: Any) -> None:
        raise AssertionError("fitted")

    monkeypatch.setattr(job.Job, "fit", fit)
    monkeypatch.setattr(job.Job, "publish", fit)


def error(command: str, *arguments: object) -> str:
    """What a command of `throw` refuses, as the command line prints it."""
    result = CliRunner().invoke(app, ["throw", command, *map(str, arguments)])
    assert isinstance(result.exception, Error), result.output
    return str(result.exception)


@pytest.mark.usefixtures("nothing_fitted")
@pytest.mark.parametrize(
    ("command", "arguments", "message"),
    [
        ("fit", ["--channel", "m1=DELT"], "--channel is of use only with --emg"),
        ("goal", ["--release", "0.5", "--adapt", "2"], "name a goal: --target, --speed, --angle or --flight-time"),
        ("compare", [], "say what to compare: --numbers LEAST MOST, --as-published or --curve"),
        ("compare", ["--numbers", "4", "2"], "from one number of synergies to a greater"),
        ("compare", ["--numbers", "4", "6", "-n", "3"], "name --number or --numbers, not both"),
        ("goal", ["--flight-time", "-1"], "the time of a throw must be greater than 0"),
        ("fit", ["--plot", "fit.bmp"], "fit.bmp: a figure is written as"),
        ("fit", ["--plot", "no/such/folder/fit.png"], "folder"),
        (
            "goal",
            ["--target", "2", "--release", "9", "--scene", "throw_ball"],
            "the release must be within the throw, 0 to 1.5 s, not 9 s",
        ),
        (
            "goal",
            ["--target", "2", "--release", "nan", "--scene", "throw_ball"],
            "the release must be within the throw",
        ),
        ("goal", ["--target", "nan"], "the distance of a throw"),
        ("fit", ["--fidelity", "inf"], "price"),
        ("fit", ["--low-pass", "80"], "below half the sampling rate, 50 Hz"),
        ("fit", ["--emg", "e.h5", "-n", "3"], "--number is for computed synergies"),
        ("compare", ["--emg", "e.h5", "--numbers", "3", "4"], "--number is for computed synergies"),
    ],
)
def test_what_cannot_be_done_is_refused_before_the_fit(motion: Path, command: str, arguments: list[str], message: str):
    assert message in error(command, motion, *arguments)


@pytest.mark.usefixtures("nothing_fitted")
def test_a_low_pass_without_a_file_is_refused():
    assert "--low-pass is of use only with files" in error("goal", "--target", "2", "--low-pass", "6")


@pytest.mark.usefixtures("nothing_fitted")
def test_noise_that_no_filter_helps_against_is_refused_before_the_fit(tmp_path: Path):
    noisy = written(tmp_path / "noisy.csv", 4.0)
    assert "has noise of about" in error("fit", noisy)
    assert "--low-pass" in error("goal", noisy, "--target", "2")
    assert "--low-pass 6" in error("fit", noisy, "--low-pass", "0")
    assert "--low-pass 6" in error("compare", noisy, "--as-published")


def test_noisy_motions_pass_a_filter_that_is_told_and_clean_ones_none(tmp_path: Path):
    made = job.Job(job.load("throw"), [written(tmp_path / "noisy.csv", 0.05)], job.JobOptions())
    assert "by residual analysis" in made.notes()[0]
    assert "--low-pass 0 for none" in made.notes()[0]
    clean = job.Job(job.load("throw"), [written(tmp_path / "clean.csv")], job.JobOptions())
    assert clean.low_pass is None
    # What is extracted is then nearly what it is without noise: 0.3 or less where accelerations are lost in it.
    signals = [one.follower.synergies.excitation(one.follower.synergies.signals) for one in (made, clean)]
    assert np.corrcoef(signals[0].ravel(), signals[1].ravel())[0, 1] > 0.95


def test_a_whole_body_has_its_activations_computed_with_groups_about_its_own_angles(motion: Path):
    """Else they come from single muscles, which are too weak for a throw, and no fit follows such signals."""
    made = job.Job(job.load("throw_body"), [motion], job.JobOptions())
    groups, individual = job.load(job.GROUPS).character.muscles, made.arm.scene.character.muscles
    for name, muscle in made.strong.scene.character.muscles.items():
        assert muscle.f_max == groups[name].f_max
        assert [p.axis for p in muscle.pulleys] == [p.axis for p in individual[name].pulleys]


def test_what_a_low_pass_took_and_what_a_file_does_not_say_is_told(tmp_path: Path):
    options = job.JobOptions(low_pass=6.0)
    made = job.Job(job.load("throw"), [written(tmp_path / "noisy.csv", 2.0)], options)
    told = made.notes()
    assert "low-pass at 6 Hz" in told[0]
    assert "deg of elbow" in told[0]
    assert (
        "noisy: no trunk_pitch_deg or shoulder_flexion_gravity_deg, so the trunk is taken to stand upright" in told[1]
    )
    assert "noisy: no shoulder_forward_m and shoulder_up_m, so the shoulder is taken to stand still" in told[2]
    assert len(told) == 3
    assert job.Job(job.load("throw"), [], job.JobOptions()).notes() == []


def test_a_missed_goal_is_said_and_ends_with_code_1(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(job, "Settings", quick)
    monkeypatch.setattr(signal_search, "GENERATIONS", 3)
    monkeypatch.setattr(signal_search, "WAYS", FEW)
    monkeypatch.setattr(strength, "FACTORS", (1.25,))
    arguments = [
        "throw",
        "goal",
        "--scene",
        "throw_ball",
        "--target",
        "60",
        "--adapt",
        "1",
        "-o",
        str(tmp_path / "t.h5"),
        "--plot",
        "t.png",
    ]
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, arguments, standalone_mode=False)
    assert result.exception is None, result.exception
    assert result.return_value == 1
    output = " ".join(result.output.split())
    assert "no signals were found that throw to 60 m overhead: distance; muscles 1.25 times as strong do not" in output
    assert "--adapt 5 lets all signals change" in output
    assert (tmp_path / "t.h5").is_file()
    assert (tmp_path / "t.png").is_file()


def quick(**given: Any) -> Settings:
    return Settings(common=False, parameter_steps=3, signal_steps=3, starts=1, **given)


def throw(folder: Path, *arguments: object) -> Any:
    """What a command of `throw` says, with quick fits, of files in a folder."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(job, "Settings", quick)
        patch.setattr(signal_search, "GENERATIONS", 3)
        patch.setattr(signal_search, "WAYS", FEW)
        return CliRunner().invoke(app, ["throw", *map(str, arguments)], standalone_mode=False)


def interrupting(function: Callable[..., Any], calls: int) -> Callable[..., Any]:
    """The same, with Ctrl-C in place of the call after so many of them."""
    count = itertools.count()

    def called(*given: Any, **named: Any) -> Any:
        if next(count) == calls:
            raise KeyboardInterrupt
        return function(*given, **named)

    return called


def test_an_interrupted_fit_keeps_what_its_last_whole_stage_came_to(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    monkeypatch.setattr(fit._Fitting, "_signals", interrupting(fit._Fitting._signals, 0))
    result = throw(tmp_path, "goal", "--scene", "throw_ball", "--target", "2", "-o", "t.h5", "--plot", "t.png")
    assert result.return_value == 130, result.exception
    assert "done so far: the fit up to its stage 'parameters'; the same command starts again" in result.output
    with h5py.File(tmp_path / "t.h5") as file:
        assert [name.decode() for name in file["fit/stages"][:]] == ["start", "equations", "parameters"]
        assert len(file["fit/r2"]) == 3
    assert len(read(tmp_path / "t.h5").replays) == 1
    assert (tmp_path / "t.png").is_file()


def test_an_interrupted_search_for_throws_keeps_the_fit_and_those_that_were_made(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    monkeypatch.setattr(synthesis.Thrower, "_throw", interrupting(synthesis.Thrower._throw, 1))
    monkeypatch.setattr(job, "what_lacks", lambda *_: "")
    result = throw(tmp_path, "goal", "--scene", "throw_ball", "--target", "2", "--target", "3", "-o", "t.h5")
    assert result.return_value == 130, result.exception
    assert "done so far: the fit, 1 of 2 new throws; the same command starts again" in result.output
    assert "to 2 m: released after" in " ".join(result.output.split())
    assert len(read(tmp_path / "t.h5").replays) == 2


def test_a_fit_that_is_interrupted_at_its_begin_leaves_the_file_of_an_earlier_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
):
    (tmp_path / "t.h5").write_text("earlier")
    monkeypatch.setattr(fit._Fitting, "_equations", interrupting(fit._Fitting._equations, 0))
    result = throw(tmp_path, "goal", "--scene", "throw_ball", "--target", "2", "-o", "t.h5")
    assert result.return_value == 130, result.exception
    assert "done so far: no stage of the fit; the same command starts again" in result.output
    assert (tmp_path / "t.h5").read_text() == "earlier"


@pytest.mark.long
def test_interrupted_fits_with_several_numbers_of_synergies_keep_one_that_is_whole(
    monkeypatch: pytest.MonkeyPatch, motion: Path, tmp_path: Path
):
    monkeypatch.setattr(job.Job, "fit", interrupting(job.Job.fit, 1))
    result = throw(tmp_path, "compare", motion, "--numbers", "4", "6", "-o", "t.h5")
    assert result.return_value == 130, result.exception
    assert "done so far: 1 of 3 numbers of synergies; the same command starts again" in result.output
    with h5py.File(tmp_path / "t.h5") as file:
        assert file["synergies/W"].shape[1] == 4
        assert file["fit/stages"][-1] == b"signals"


@pytest.mark.parametrize(("missed", "code"), [((), 0), (("distance",), 1), (("angle",), 4), (("distance", "speed"), 6)])
def test_the_exit_code_tells_what_was_missed(missed: tuple[str, ...], code: int):
    throws: list[Any] = [SimpleNamespace(missed={}), SimpleNamespace(missed=dict.fromkeys(missed, 1.0))]
    assert exit_code(throws) == code


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("fit", ("shoulder_flexion_gravity_deg", "trunk_pitch_deg", "shoulder_forward_m", "shoulder_up_m")),
        ("goal", ("1 (distance), 3 (speed), 4 (angle), 5 (time of flight), 7 (limits of joints)",)),
    ],
)
def test_columns_and_exit_codes_are_in_the_help(command: str, words: tuple[str, ...]):
    text = " ".join(CliRunner().invoke(app, ["throw", command, "--help"]).output.replace("│", " ").split())
    for word in (*words, "Exit codes"):
        assert word in text
