"""Code that the scenes of a sweep name: refused in one line before anything begins; if trusted, run, on workers too."""

import sys
from pathlib import Path

import pytest

from muscle_arm import constant, leg
from small_sweep import assert_same_file
from warpmuscle.cli import program
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.results.result import read
from warpmuscle.scene.number import Free
from warpmuscle.sweep import cluster
from warpmuscle.sweep.named_code import named_by, trusted_there
from warpmuscle.sweep.run import sweep

MODULE = """import warp as wp
from warpmuscle.kernels.objective.term_functions import MuscleWork
from warpmuscle.kernels.structs import Model
@wp.func
def effort(instance: int, m: int, w: MuscleWork, model: Model) -> float: return w.activation * w.activation
"""


def sweep_file(folder: Path, module: str) -> Path:
    """A sweep of two runs of a scene that names a function of a module beside it."""
    scene = leg(duration=0.05)
    muscle = next(iter(scene.character.muscles.values()))
    muscle.f_max, muscle.excitation = Free(1000.0, 500.0, 2000.0), constant(0.5)
    scene.objective.custom = {f"{module}:effort": 2.0}
    folder.mkdir(exist_ok=True)
    toml.write(scene, folder / "theirs.toml")
    (folder / f"{module}.py").write_text(MODULE)
    file = folder / "sweep.toml"
    file.write_text('scene = "theirs.toml"\n[search]\ncandidates = 4\npopulation = 2\n[grid]\nseed = [1, 2]\n')
    return file


def command(monkeypatch, capsys, *arguments: object) -> tuple[int, list[str]]:
    monkeypatch.setattr("sys.argv", ["warpmuscle", *map(str, arguments)])
    monkeypatch.setenv("COLUMNS", "400")
    with pytest.raises(SystemExit) as left:
        program.main()
    return int(left.value.code or 0), capsys.readouterr().err.strip().splitlines()


def test_a_sweep_says_in_one_line_what_its_scene_wants_and_begins_nothing(tmp_path, monkeypatch, capsys):
    file = sweep_file(tmp_path, "refused_parts")
    code, errors = command(monkeypatch, capsys, "sweep", file, "-o", tmp_path / "out.h5", "--device", "cpu")
    assert (code, len(errors)) == (2, 1)
    assert "wants to run code of 'refused_parts:effort'; if you trust it, say so: --trust" in errors[0]
    assert not list(tmp_path.glob("out*"))
    assert "refused_parts" not in sys.modules


def test_a_trusted_sweep_runs_here_and_on_workers_that_have_no_such_module(tmp_path, monkeypatch):
    ray = pytest.importorskip("ray", reason="Ray is not installed: pip install warpmuscle[cluster]")
    here = sweep(sweep_file(tmp_path / "here", "sweep_parts"), tmp_path / "here.h5", device="cpu", trust=True)
    assert (here.failed, here.gathered) == ({}, 2)
    assert read(tmp_path / "here.h5", "seed=1").evaluations.term_names[-1] == "sweep_parts:effort"
    original = cluster._work

    def elsewhere(tasks, folder, token, known, code, *more):
        nowhere = cluster.NamedCode(code.scenes, (), code.files)
        return original(tasks, folder, "another", known, nowhere, *more)

    monkeypatch.setattr(cluster, "_work", elsewhere)
    ray.init(address="local", num_cpus=1, include_dashboard=False, log_to_driver=False)
    try:
        file = sweep_file(tmp_path / "there", "sweep_parts")
        there = sweep(file, tmp_path / "there.h5", cluster="auto", device="cpu", trust=True)
    finally:
        ray.shutdown()
    assert there.failed == {}
    assert_same_file(tmp_path / "there.h5", tmp_path / "here.h5")


def test_modules_in_packages_are_carried_with_what_makes_them_packages(tmp_path, monkeypatch):
    package = tmp_path / "outer" / "inner"
    package.mkdir(parents=True)
    for file in (package.parent / "__init__.py", package / "__init__.py", package / "parts.py"):
        file.write_text("")
    monkeypatch.chdir(tmp_path)
    scene = leg()
    scene.objective.custom = {"outer.inner.parts:effort": 1.0}
    with pytest.raises(SceneError, match="wants to run code"):
        named_by([scene])
    with trusted_there(cluster.NamedCode((scene,))):
        names = [Path(name).as_posix() for name, _ in named_by([scene]).files]
    assert sorted(names) == ["outer/__init__.py", "outer/inner/__init__.py", "outer/inner/parts.py"]
