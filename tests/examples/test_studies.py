"""Published studies that are shipped: each can be read, says what is expected and by whom, and is found by its name."""

import re
import warnings
from pathlib import Path

import pytest

import command_line
from warpmuscle.cli.sweep import study_file
from warpmuscle.core.errors import SceneError
from warpmuscle.examples.studies import LEVEL_WALK, STUDIES, study_files, study_text
from warpmuscle.formats import load
from warpmuscle.model.muscles import driven
from warpmuscle.scene.anatomy import leg_joints
from warpmuscle.scene.topology import topology
from warpmuscle.sweep.plan import read
from warpmuscle.sweep.union import groups


@pytest.mark.parametrize("name", STUDIES)
def test_a_shipped_study_has_conditions_seeds_and_expectations_with_sources(name: str, tmp_path: Path):
    for file, text in study_files(name).items():
        (tmp_path / file).write_text(text)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # such as of a start in the ground
        plan = read(tmp_path / f"{name}.toml")
    study = plan.study
    assert study is not None
    assert study.title
    assert study.text
    assert {run.seed for run in plan.runs} == {1, 2, 3, 4, 5, 6}  # from six on, an interval has the median
    conditions = {study.condition_of(run.axes) for run in plan.runs}
    assert len(conditions) * 6 <= len(plan.runs)
    assert study.reference in conditions
    assert study.expected
    assert all(expected.source and expected.at in conditions for expected in study.expected)
    batches = groups(plan.scenes)  # conditions that differ in numbers only are simulated together
    assert len(batches) == (3 if name == "locked_ankles" else 1)


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("impairments.calves.f_max", "impairments.calfs.f_max", "impairments.calfs.f_max"),
        ('muscles = ["?SOL", "?GAS"] }', 'muscles = ["?SOLE"] }', "impairments.calves"),
        ('change = "falls"', 'chance = "falls"', "study.expected.0.chance"),
        ("damping = 0.5", "dumping = 0.5", "forces.left_brace"),
    ],
)
def test_a_wrong_key_of_a_study_is_named_with_its_line(old: str, new: str, key: str, tmp_path: Path):
    text = study_text("brace").replace(old, new, 1)
    line = text[: text.index(new)].count("\n") + 1
    for name, content in (study_files("brace") | {"brace.toml": text}).items():
        (tmp_path / name).write_text(content)
    file = tmp_path / "brace.toml"
    with pytest.raises(SceneError, match=re.escape(key)) as caught:
        read(file)
    assert caught.value.line == line


def test_a_study_is_written_with_the_walk_that_it_begins_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "level_walk.toml").write_text("one's own")
    assert study_file(Path("slopes")) == Path("slopes.toml")
    assert (tmp_path / "level_walk.toml").read_text() == "one's own"
    (tmp_path / "level_walk.toml").unlink()
    study_file(Path("slopes"))
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == study_files("slopes")


def test_legs_of_planar_studies_have_joints_in_the_plane_that_muscles_alone_drive(tmp_path: Path):
    """Torques that turn a hip out of the plane of the root give the walk energy that no cost counts."""
    for file, text in study_files("slopes").items():
        (tmp_path / file).write_text(text)
    scene = load(tmp_path / LEVEL_WALK)
    drives = driven(scene, topology(scene.character)).drives
    for joint in (name for side in (0, 1) for name in leg_joints(scene, side)):
        assert scene.character.joints[joint].axes == [(1.0, 0.0, 0.0)]
        assert drives[joint] == ["muscle"]
    planar = {name for name in STUDIES if LEVEL_WALK in study_files(name)}
    assert planar == STUDIES.keys() - {"weakness"}


def test_an_unknown_study_is_answered_by_those_that_there_are(tmp_path: Path):
    done = command_line.run("study", "braces", folder=tmp_path)
    assert done.returncode == 2
    assert "no shipped study; did you mean 'brace'" in " ".join((done.stdout + done.stderr).split())
    assert not list(tmp_path.iterdir())
