"""Points between limits: how evenly they lie, that more of them begin with the same, and what is refused."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import qmc

from warpmuscle.core.errors import SceneError
from warpmuscle.sweep.plan import read

TEXT = """
scene = "fwalk"
[set]
duration = 0.1
[search]
candidates = 4
[sample]
points = {points}
method = "{method}"
seed = {seed}
[sample.axes]
objective.torque = {{ min = 1, max = 3 }}
strength = {{ keys = ["character.bodies.*.mass"], min = 0.5, max = 2, scale = "log", factor = true }}
[grid]
seed = [1, 2]
"""


def runs(folder: Path, points: int = 8, method: str = "sobol", seed: int = 1):
    (folder / "a.toml").write_text(TEXT.format(points=points, method=method, seed=seed))
    return read(folder / "a.toml").runs


@pytest.mark.parametrize("method", ["sobol", "random"])
def test_a_point_has_a_value_on_each_axis_and_is_run_with_every_seed(method: str, tmp_path: Path):
    found = runs(tmp_path, method=method)
    assert len(found) == 16
    assert found[3].name == "point=1,seed=2"
    mass = read_mass(tmp_path)
    for run in found:
        axes = run.axes
        assert set(axes) == {"point", "seed", "torque", "strength"}
        assert run.scene.objective.torque == axes["torque"]
        assert 1.0 <= axes["torque"] < 3.0
        assert 0.5 <= axes["strength"] <= 2.0
        assert run.scene.character.bodies["torso"].mass == pytest.approx(mass * axes["strength"])
        assert run.units["strength"] == "1"
    assert found[0].scene is found[1].scene


def read_mass(folder: Path) -> float:
    (folder / "b.toml").write_text('scene = "fwalk"\n')
    return float(read(folder / "b.toml").runs[0].scene.character.bodies["torso"].mass)


@pytest.mark.parametrize("method", ["sobol", "random"])
def test_more_points_of_a_seed_begin_with_the_earlier_ones(method: str, tmp_path: Path):
    few = {run.name: run.axes for run in runs(tmp_path, 4, method)}
    many = {run.name: run.axes for run in runs(tmp_path, 8, method)}
    assert few.items() <= many.items()
    assert few != {run.name: run.axes for run in runs(tmp_path, 4, method, seed=2)}


def test_sobol_points_fill_the_square_more_evenly_than_random_ones(tmp_path: Path):
    spread = {}
    for method in ("sobol", "random"):
        axes = [run.axes for run in runs(tmp_path, 32, method)[::2]]
        points = [((a["torque"] - 1) / 2, np.log(a["strength"] / 0.5) / np.log(4)) for a in axes]
        spread[method] = qmc.discrepancy(np.array(points))
    assert spread["sobol"] < 0.2 * spread["random"]


@pytest.mark.parametrize(
    ("before", "after", "key", "message"),
    [
        ("points = 8", "points = 0", "sample.points", "one point at least"),
        ("min = 1, max = 3", "min = 3, max = 1", "sample.axes.objective.torque", "min must be below max"),
        ("min = 0.5", "min = -1", "sample.axes.strength.min", "begins above 0"),
        ("objective.torque", "search.sigma", "sample.axes.search.sigma", r"put this into \[grid\]"),
        ("objective.torque", "objective.torqe", "objective.torqe", "did you mean"),
        ("max = 3 }", "max = 3, step = 1 }", "sample.axes.objective.torque.step", "unknown"),
        ('"sobol"', '"halton"', "sample.method", "sobol"),
        ("seed = 1\n", "seed = -1\n", "sample.seed", "0 at least"),
        ("objective.torque", "a.strength", "sample.axes", "two axes would be called"),
    ],
)
def test_what_cannot_be_sampled_is_refused_with_its_key(before, after, key, message, tmp_path: Path):
    text = TEXT.format(points=8, method="sobol", seed=1)
    assert before in text
    (tmp_path / "a.toml").write_text(text.replace(before, after, 1))
    with pytest.raises(SceneError, match=message) as caught:
        read(tmp_path / "a.toml")
    assert caught.value.key == key
    assert caught.value.line > 0


def test_a_value_that_stands_twice_is_refused(tmp_path: Path):
    (tmp_path / "a.toml").write_text('scene = "fwalk"\n[grid]\nseed = [1, 2, 1]\n')
    with pytest.raises(SceneError, match=r"a.toml:3: grid.seed: the axis has the value 1 twice"):
        read(tmp_path / "a.toml")


def test_an_axis_that_is_nearly_the_seed_is_named(tmp_path: Path):
    (tmp_path / "a.toml").write_text('scene = "fwalk"\n[grid]\nseeds = [1, 2]\n')
    with pytest.raises(SceneError, match=r"a.toml:3: grid.seeds: a scene has no such key; did you mean 'seed'\?"):
        read(tmp_path / "a.toml")
