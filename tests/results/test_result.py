"""Result files: what goes in comes out, bytes repeat, nothing half-written, clear errors."""

import dataclasses
import os
from pathlib import Path

import h5py
import msgspec
import numpy as np
import pytest

from biped import random_recording
from described import assert_described
from same_values import assert_same
from small_disk import disk_of
from warpmuscle.core.errors import ResultError
from warpmuscle.core.status import Status
from warpmuscle.formats import load, toml
from warpmuscle.results.journal import Journal
from warpmuscle.results.recorded_quantities import QUANTITIES
from warpmuscle.results.records import (
    TABLE,
    Best,
    Evaluations,
    History,
    ParameterTable,
    Result,
    Searched,
    SearchOptions,
    Staged,
)
from warpmuscle.results.result import read, write
from warpmuscle.scene import Objective


def full_result(evaluations: int = 300) -> Result:
    """A result with everything in it."""
    rng = np.random.default_rng(0)
    found = Evaluations(
        params=rng.random((evaluations, 2)),
        cost=rng.random(evaluations),
        status=rng.integers(1, 6, evaluations),
        end_time=rng.random(evaluations),
        search=rng.integers(-1, 2, evaluations),
        generation=np.arange(evaluations) // 100,
        stage=np.arange(evaluations) // 150,
        terms=np.where(rng.random((evaluations, 3)) < 0.1, np.nan, 1.0),
        term_names=("torque", "fall", "speed"),
    )
    table = ParameterTable(
        ("controller.pd.lHip.kp", "kd ü"), ("N m/rad", "1"), np.array([0.1, 0.0]), np.ones(2), np.array([0.0, 0.1]),
        np.ones(2), ("log", "linear"),
    )  # fmt: skip
    history = History(
        *np.arange(6).reshape(2, 3),
        *rng.random((3, 3)),
        np.array([0.1, np.nan, 0.2]),
        np.array([0, 1, 2**32 - 1]),
        np.array([0, 0, 1]),
    )
    states = {"mean": np.ones(2), "sigma": np.array(0.1), "C": np.eye(2)}, {"sigma": np.array(np.nan)}
    options = SearchOptions("cma", searches=2, sigma=0.3, target=1.5)
    stages = (
        Staged("survive", ("kd ü",), SearchOptions("random", until=3.5), "the time is up", Best(np.zeros(2), 0.5, 3)),
        Staged("walk", ("controller.pd.lHip.kp", "kd ü"), options),
    )
    searched = Searched(options, "the target is reached", history, states, stages, 1)
    best = Best(found.params[7], float(found.cost[7]), 7)
    replays = (random_recording(muscles=4), random_recording(30, joints=2, seed=1))
    return Result('name = "größe"\n', "cpu", "optimize a.toml", 42, table, found, best, replays, searched)


def plain_result() -> Result:
    """A result without free parameters, evaluations, replays."""
    return Result("", "cuda:0", "simulate", 0, ParameterTable((), (), *np.zeros((4, 0)), ()))


@pytest.mark.parametrize("make", [full_result, plain_result])
def test_reading_gives_back_what_was_written(make, tmp_path: Path):
    write(tmp_path / "a.h5", make())
    assert_same(read(tmp_path / "a.h5"), make())


def test_same_result_gives_the_same_bytes(tmp_path: Path):
    for name in "ab":
        write(tmp_path / name, full_result())
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    with h5py.File(tmp_path / "a") as file:
        assert h5py.h5o.get_info(file["evaluations/cost"].id).mtime == 0


def test_candidates_take_less_than_100_bytes_beside_their_parameters(tmp_path: Path):
    result, count = full_result(20_000), 20_000
    numbers, random = np.arange(count), np.random.default_rng(0).random((5, count))
    history = History(numbers, numbers % 3, *random[:4], np.asarray(random[4] * 2**32, dtype=np.int64), numbers // 9)
    searched = dataclasses.replace(result.searched, history=history)  # a generation a candidate, as of nlopt
    write(tmp_path / "a.h5", dataclasses.replace(result, replays=(), searched=searched))
    assert (tmp_path / "a.h5").stat().st_size < count * (100 + 2 * 8)


def test_file_tells_foreign_readers_what_it_holds(tmp_path: Path):
    write(tmp_path / "a.h5", full_result())
    with h5py.File(tmp_path / "a.h5") as file:
        assert (file.attrs["format"], file.attrs["format_version"], file.attrs["seed"]) == ("warpmuscle", 3, 42)
        for name in ("warpmuscle", "warp", "numpy", "h5py", "python"):
            assert file.attrs[f"{name}_version"][0].isdigit()
        assert file["scene"].asstr()[()] == 'name = "größe"\n'
        for name, quantity in QUANTITIES.items():
            if quantity.axes[-1] in (
                "coordinate",
                "speed",
                "joint_angle",
                "controller_value",
                "recorded",
            ):  # this recording has none
                assert name not in file["replay/0"]
                continue
            attributes = file[f"replay/0/{name}"].attrs
            assert (attributes["units"], attributes["description"]) == (quantity.units, quantity.description)
            assert attributes["axes"].split(", ") == list(quantity.axes)
            assert attributes["at"] == quantity.at
        assert file["replay/0/muscle_activation"].attrs["at"].startswith("end of the step")
        assert file["replay/0/muscle_force"].attrs["at"].startswith("start of the step")
        assert file["replay/0/com"].attrs["at"] == "start of the step"
        status = file["evaluations/status"]
        assert {member.name: status.attrs[member.name] for member in Status} == Status.__members__
        params = file["evaluations/params"]
        assert (params.compression, params.shuffle) == ("gzip", True)


def test_coordinates_are_read_back_with_their_names(tmp_path: Path):
    result, values = full_result(), np.arange(8.0).reshape(4, 2)
    named = dataclasses.replace(
        random_recording(4), coordinate=values, coordinate_names=("root.y", "knee"), speed=values[:, :1],
        speed_names=("knee",),
    )  # fmt: skip
    write(tmp_path / "a.h5", dataclasses.replace(result, replays=(named,), replay_names=()))
    found = read(tmp_path / "a.h5").replays[0]
    assert (found.coordinate_names, found.speed_names) == (named.coordinate_names, named.speed_names)
    assert np.array_equal(found.coordinate, values)
    assert np.array_equal(found.speed, values[:, :1])
    assert found.window(0.5).coordinate_names == named.coordinate_names


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_number_that_is_not_finite_is_named_and_not_written(value: float, tmp_path: Path):
    result = full_result()
    result.replays[1].com_velocity[3, 1] = value
    with pytest.raises(ResultError, match="/replay/1/com_velocity holds a value that is not finite"):
        write(tmp_path / "a.h5", result)
    with pytest.raises(ResultError, match="best/cost"):
        write(tmp_path / "a.h5", dataclasses.replace(full_result(), best=Best(np.zeros(2), value, 0)))
    assert not list(tmp_path.iterdir())


def test_no_infinite_number_is_written_of_a_search_that_knows_no_cost_yet(tmp_path: Path):
    result = full_result()
    states = {"mean": np.ones(2), "best_cost": np.array(np.inf)}, {"best_cost": np.array(1.5)}
    searched = dataclasses.replace(result.searched, states=states)
    write(tmp_path / "a.h5", dataclasses.replace(result, searched=searched))
    first, second = read(tmp_path / "a.h5").searched.states
    assert set(first) == {"mean"}
    assert float(second["best_cost"]) == 1.5


def test_arrays_that_do_not_fit_each_other_are_not_written(tmp_path: Path):
    result = full_result()
    shorter = dataclasses.replace(result.evaluations, status=result.evaluations.status[1:])
    with pytest.raises(ResultError, match=r"evaluations/status has shape \(299,\), not \(300,\)"):
        write(tmp_path / "a.h5", dataclasses.replace(result, evaluations=shorter))
    assert not list(tmp_path.iterdir())


def test_missing_folder_is_one_clear_error(tmp_path: Path):
    with pytest.raises(ResultError, match=r"a\.h5: cannot be written: its folder does not exist"):
        write(tmp_path / "nowhere" / "a.h5", plain_result())


def test_name_of_a_folder_is_one_clear_error_and_leaves_no_temporary_file(tmp_path: Path):
    (tmp_path / "a.h5").mkdir()
    with pytest.raises(ResultError, match=r"a\.h5: cannot be written: this is a folder"):
        write(tmp_path / "a.h5", plain_result())
    assert [path.name for path in tmp_path.iterdir()] == ["a.h5"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write anywhere")
def test_folder_without_permission_is_one_clear_error(tmp_path: Path):
    tmp_path.chmod(0o500)
    with pytest.raises(ResultError, match="cannot be written: Permission denied"):
        write(tmp_path / "a.h5", plain_result())


def test_full_disk_leaves_the_old_file_and_no_other(tmp_path: Path):
    path = tmp_path / "a.h5"
    write(path, plain_result())
    old = path.read_bytes()
    with disk_of(2000), pytest.raises(ResultError, match=r"a\.h5: cannot be written: file too large"):
        write(path, full_result())
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == old


def test_foreign_files_are_refused(tmp_path: Path):
    (tmp_path / "text.h5").write_text("hello")
    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["x"] = 1.0
    for name, reason in {"text.h5": "not an HDF5 file", "other.h5": "not one written by warpmuscle"}.items():
        with pytest.raises(ResultError, match=f"{name}: .*{reason}"):
            read(tmp_path / name)
    with pytest.raises(ResultError, match=r"missing\.h5: no such file"):
        read(tmp_path / "missing.h5")
    with pytest.raises(ResultError, match=r"cannot be read|not an HDF5 file"):
        read(tmp_path)


def test_files_and_journals_of_before_there_were_stages_are_read(tmp_path: Path):
    result = full_result()
    first = dataclasses.replace(result.evaluations, stage=np.zeros(300, dtype=np.int32))
    history = dataclasses.replace(result.searched.history, stage=np.zeros(3, dtype=np.int64))
    searched = dataclasses.replace(result.searched, stages=(), stage=0, history=history)
    plain = dataclasses.replace(result, evaluations=first, searched=searched)
    write(tmp_path / "a.h5", plain)
    with h5py.File(tmp_path / "a.h5", "a") as file:
        assert "stages" not in file
        assert "stage" not in file["best"]
        del file["evaluations/stage"], file["history/stage"]
    assert_same(read(tmp_path / "a.h5"), plain)
    with pytest.MonkeyPatch.context() as patch, Journal(tmp_path / "a.journal", "run") as journal:
        patch.setattr("warpmuscle.results.journal.TABLE", tuple(name for name in TABLE if name != "stage"))
        journal.append(first.rows(first.generation == 0))
    with Journal(tmp_path / "a.journal", "run") as journal:
        assert_same(journal.generations()[0], first.rows(first.generation == 0))


def test_newer_format_is_refused(tmp_path: Path):
    write(tmp_path / "a.h5", plain_result())
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file.attrs["format_version"] = 4
    with pytest.raises(ResultError, match="format version 4 is newer than 3"):
        read(tmp_path / "a.h5")


def test_every_dataset_says_its_unit_axes_and_what_it_is(tmp_path: Path):
    write(tmp_path / "a.h5", full_result())
    assert_described(tmp_path / "a.h5")


@pytest.mark.parametrize(
    ("objective", "meant"),
    [({}, {"torque": 1.0}), ({"speed": 2.0}, {"torque": 1.0, "speed": 2.0}), ({"torque": 0.5}, {"torque": 0.5})],
)
def test_torque_weighs_in_files_of_the_first_version_what_it_did_then(tmp_path: Path, objective, meant):
    scene = msgspec.structs.replace(load("fwalk"), objective=Objective(**objective))
    write(tmp_path / "a.h5", dataclasses.replace(plain_result(), scene=toml.dumps(scene)))
    assert toml.loads(read(tmp_path / "a.h5").scene).objective == Objective(**objective)
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file.attrs["format_version"] = 1
    assert toml.loads(read(tmp_path / "a.h5").scene).objective == Objective(**meant)


def test_damaged_files_are_refused(tmp_path: Path):
    path = tmp_path / "a.h5"
    write(path, full_result())
    content = path.read_bytes()
    path.write_bytes(content[: len(content) // 2])
    with pytest.raises(ResultError, match="damaged"):
        read(path)
    path.write_bytes(content)
    with h5py.File(path, "a") as file:
        del file["replay/0/time"]
    with pytest.raises(ResultError, match=r"damaged result file: .*time"):
        read(path)


def test_a_command_with_a_file_s_name_in_other_bytes_is_written(tmp_path: Path):
    """Python keeps bytes that are no UTF-8 as halves of letters, which HDF5 does not take."""
    write(tmp_path / "walk.h5", dataclasses.replace(plain_result(), command="warpmuscle simulate L\udce4ufe.toml"))
    assert read(tmp_path / "walk.h5").command == "warpmuscle simulate L\ufffdufe.toml"
