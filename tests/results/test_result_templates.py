"""Files that are stamped from one without numbers say what those say that are written one by one."""

import dataclasses
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from small_result import search_result
from small_sweep import assert_same_file
from warpmuscle.core.errors import ResultError
from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.results import result_templates
from warpmuscle.results.records import Result
from warpmuscle.results.result import image, read, write
from warpmuscle.results.result_templates import Stamps

PHASES = ("phase", "stance", "state")


@pytest.fixture(scope="module")
def results() -> list[Result]:
    """Searches that differ in their seeds, strategies and scenes."""
    scene = load("fwalk")
    scene.duration = 0.05
    heavy = load("fwalk")
    heavy.duration, heavy.character.bodies["torso"].mass = 0.05, 33.0
    found = [optimize(scene, 14, seed, "cpu", population=6) for seed in (1, 2)]
    found.append(optimize(heavy, 14, 1, "cpu", population=6))
    motion = found[0].replays[0]
    phases = {name: getattr(motion, name)[:0] for name in PHASES}  # scenes without a controller have none
    found.append(dataclasses.replace(found[0], replays=(motion.changed(**phases),)))
    assert found[-1].replays[0].missing == PHASES
    return [*found, optimize(scene, 9, 1, "cpu", search="random", population=3), search_result()]


def scales(path: Path) -> dict[str, list[list[str]]]:
    found = {}
    with h5py.File(path) as file:
        file.visititems(
            lambda name, item: found.update({name: [list(axis.keys()) for axis in item.dims]})
            if isinstance(item, h5py.Dataset) else None
        )  # fmt: skip
    return found


def test_every_file_says_what_is_said_of_it_alone(results, tmp_path: Path):
    stamps = Stamps()
    for result in [*results, *results[::-1]]:
        write(tmp_path / "alone.h5", result)
        (tmp_path / "stamped.h5").write_bytes(stamps.image(result))
        assert_same_file(tmp_path / "stamped.h5", tmp_path / "alone.h5")
        assert scales(tmp_path / "stamped.h5") == scales(tmp_path / "alone.h5")
        found = read(tmp_path / "stamped.h5")
        assert found.scene == result.scene
        np.testing.assert_array_equal(found.replays[0].com, result.replays[0].com)


def test_bytes_depend_on_nothing_but_the_result(results):
    stamps = Stamps()
    first = [stamps.image(result) for result in results]
    assert first == [Stamps().image(result) for result in results]
    assert first[::-1] == [stamps.image(result) for result in results[::-1]]


def test_motions_that_lack_quantities_have_stamps(results, monkeypatch):
    made = []
    monkeypatch.setattr(result_templates, "image", lambda result: made.append(result) or image(result))
    stamps = Stamps()
    lacking = next(result for result in results if result.replays[0].missing)
    assert stamps.image(lacking) == stamps.image(lacking)
    assert len(made) == 1  # of the file without numbers, and none of a whole one


def test_what_has_no_stamp_is_written_as_alone(results):
    plain = dataclasses.replace(results[0], replays=(), parts={})
    assert Stamps().image(plain) == image(plain)


def test_numbers_that_are_not_finite_are_refused_as_alone(results):
    evaluations = dataclasses.replace(results[0].evaluations, cost=np.full(len(results[0].evaluations), np.nan))
    wrong = dataclasses.replace(results[0], evaluations=evaluations)
    with pytest.raises(ResultError) as alone:
        image(wrong)
    with pytest.raises(ResultError, match=re.escape(str(alone.value))):
        Stamps().image(wrong)


def test_long_motions_are_compressed_beside_hdf5_and_read_by_it(results, tmp_path: Path):
    result = results[-1]
    stamps = Stamps()
    (tmp_path / "stamped.h5").write_bytes(stamps.image(result))
    (blank,) = stamps._blanks.values()
    assert {"replay/0/joint_orientation", "replay/0/com"} <= set(blank.packed)  # in chunks that do not fill the array
    with h5py.File(tmp_path / "stamped.h5") as file:
        for name, array in result.replays[0].__dict__.items():
            if f"replay/0/{name}" in blank.packed:
                np.testing.assert_array_equal(file[f"replay/0/{name}"][()], array)
        assert any(size % chunk for path in blank.packed
                   for size, chunk in zip(file[path].shape, file[path].chunks, strict=True))  # fmt: skip
    sizes = [len((tmp_path / "stamped.h5").read_bytes()), len(image(result))]
    assert sizes[0] <= 1.1 * sizes[1]
