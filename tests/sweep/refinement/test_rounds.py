"""Adaptive points of a sweep: chosen in rounds, the same again after an interruption, more of them later."""

from pathlib import Path

import numpy as np
import pytest

from warpmuscle.core.errors import Error, SceneError
from warpmuscle.results.result import read as read_result
from warpmuscle.sweep.folder import Folder
from warpmuscle.sweep.plan import read
from warpmuscle.sweep.refinement import rounds
from warpmuscle.sweep.refinement.rounds import CHOSEN, chosen_points, values_of
from warpmuscle.sweep.run import sweep

TEXT = """
scene = "fwalk"
[set]
duration = 0.05
[search]
candidates = 4
population = 4
[sample]
points = {points}
method = "adaptive"
first = 3
batch = 2
[sample.axes]
"character.bodies.torso.mass" = {{ min = 10, max = 60 }}
[grid]
seed = [1, 2]
"""


def plan(folder: Path, points: int):
    (folder / "a.toml").write_text(TEXT.format(points=points))
    return read(folder / "a.toml")


def costs(output: Path) -> dict[str, np.ndarray]:
    folder = Folder.of(output)
    return {entry.name: read_result(folder.result(entry.name)).evaluations.cost for entry in folder.manifest().runs}


def test_rounds_follow_from_costs_and_go_on_after_an_interruption(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    whole = tmp_path / "whole.h5"
    done = sweep(plan(tmp_path, 6), whole, device="cpu")
    assert done.gathered == 12
    assert not done.failed
    folder = Folder.of(whole).path
    chosen = chosen_points(folder, 1)
    assert chosen.shape == (3, 1)

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    cut = tmp_path / "cut.h5"
    with monkeypatch.context() as patch:
        patch.setattr(rounds, "next_points", interrupted)
        with pytest.raises(KeyboardInterrupt):
            sweep(plan(tmp_path, 6), cut, device="cpu")
    assert len(costs(cut)) == 6
    assert not cut.exists()
    sweep(plan(tmp_path, 6), cut, device="cpu")
    assert np.array_equal(chosen_points(Folder.of(cut).path, 1), chosen)
    first, second = costs(whole), costs(cut)
    assert list(first) == list(second)
    assert all(np.array_equal(first[name], second[name]) for name in first)

    stamps = {file.name: file.stat().st_mtime_ns for file in folder.glob("point=*.h5")}
    assert sweep(plan(tmp_path, 7), whole, device="cpu").gathered == 14
    assert np.array_equal(chosen_points(folder, 1)[:3], chosen)
    assert stamps == {name: (folder / name).stat().st_mtime_ns for name in stamps}  # only new ones have run
    refinement = plan(tmp_path, 7).refinement
    assert refinement is not None
    grown = refinement.grown(chosen_points(folder, 1))
    found = values_of(grown, Folder.of(whole).states(Folder.of(whole).manifest()), 7)
    both = [[first[f"point={k},seed={seed}"].min() for seed in (1, 2)] for k in range(6)]
    assert found[:6, 0] == pytest.approx(np.mean(both, axis=1))

    (folder / CHOSEN).write_text("[[0.2, 0.3]]")
    with pytest.raises(Error, match=r"points\.json: these are not points of 1 axis"):
        sweep(plan(tmp_path, 7), whole, device="cpu")
    (folder / CHOSEN).write_text("[[0.2")
    with pytest.raises(Error, match=r"points\.json: is damaged"):
        sweep(plan(tmp_path, 7), whole, device="cpu")


def test_parts_of_an_adaptive_sweep_are_refused(tmp_path: Path):
    with pytest.raises(Error, match="leave the parts out"):
        sweep(plan(tmp_path, 4), tmp_path / "a.h5", device="cpu", part="1/2")


@pytest.mark.parametrize(
    ("before", "after", "key", "message"),
    [
        ("first = 3", "first = 0", "sample.first", "one point at least"),
        ('"adaptive"', '"sobol"', "sample.first", 'of method = "adaptive" alone'),
        ("[grid]", "[prune]\n[grid]", "sample.method", r"leave \[prune\] out"),
        ("[search]\ncandidates = 4\npopulation = 4", "[training]\nuntil = 1", "sample.method", "trainings"),
    ],
)
def test_what_cannot_be_chosen_is_refused_with_its_key(before, after, key, message, tmp_path: Path):
    text = TEXT.format(points=4)
    assert before in text
    (tmp_path / "a.toml").write_text(text.replace(before, after))
    with pytest.raises(SceneError, match=message) as caught:
        read(tmp_path / "a.toml")
    assert caught.value.key == key
