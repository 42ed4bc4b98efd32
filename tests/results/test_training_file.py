"""Files that trainings go on from: damage, files of others, and two processes at once."""

import multiprocessing
import shutil
from dataclasses import replace
from importlib.resources import files

import h5py
import numpy as np
import pytest

from patience import PATIENCE
from warpmuscle.core.errors import ResultError
from warpmuscle.results.result import read, write
from warpmuscle.results.training_file import check_belongs, locked, read_training, training_path, write_training

SHIPPED = files("warpmuscle.examples") / "files" / "walk56_by_command.h5"
STATE = {"values": np.arange(6, dtype=np.float32), "moments.0": np.zeros((3, 2)), "step": np.array(7)}


@pytest.fixture
def policy(tmp_path):
    """A policy's file with a training beside it."""
    path = tmp_path / "p.h5"
    shutil.copy(str(SHIPPED), path)
    path.chmod(0o644)
    write_training(training_path(path), read(path), STATE)
    return path


def test_a_training_comes_back_as_it_was_written(policy):
    result, state = read_training(training_path(policy))
    assert result.scene == read(policy).scene
    for name, array in STATE.items():
        np.testing.assert_array_equal(state[name], array)


def every_array(file):
    found = []
    file.visititems(lambda name, one: found.append(name) if isinstance(one, h5py.Dataset) else None)
    return [name for name in found if file[name].dtype.kind in "iuf" and file[name].size]


def test_a_change_of_any_number_is_noticed(policy):
    path = training_path(policy)
    content = path.read_bytes()
    with h5py.File(path, "r") as file:
        names = every_array(file)
    assert len(names) > 20
    for name in names:
        with h5py.File(path, "r+") as file:
            values = np.array(file[name])
            values.flat[values.size // 2] += 1
            file[name][...] = values
        with pytest.raises(ResultError) as caught:
            read_training(path)
        assert "\n" not in str(caught.value)
        path.write_bytes(content)
    read_training(path)


def test_a_change_of_an_attribute_is_noticed(policy):
    with h5py.File(training_path(policy), "r+") as file:
        file["training"].attrs["ended"] = "something else"
    with pytest.raises(ResultError, match="does not hold what was written"):
        read_training(training_path(policy))


def test_a_training_without_a_digest_is_of_before_there_was_one(policy):
    with h5py.File(training_path(policy), "r+") as file:
        del file.attrs["digest"]
    read_training(training_path(policy))


def test_a_policy_of_another_scene_or_seed_is_not_replaced(policy):
    training, _ = read_training(training_path(policy))
    check_belongs(policy, training)
    for other in (replace(read(policy), seed=99), replace(read(policy), scene=training.scene.replace("0.3", "0.31"))):
        write(policy, other)
        with pytest.raises(ResultError, match="another scene or seed"):
            check_belongs(policy, training)
    policy.unlink()
    check_belongs(policy, training)


def hold(path, ready, done):
    with locked(path):
        ready.set()
        done.wait(PATIENCE)


def test_two_processes_do_not_train_into_one_file(policy):
    context = multiprocessing.get_context("spawn")
    ready, done = context.Event(), context.Event()
    other = context.Process(target=hold, args=(policy, ready, done))
    other.start()
    try:
        assert ready.wait(PATIENCE)
        with pytest.raises(ResultError, match="another process is at work"), locked(policy):
            pass
    finally:
        done.set()
        other.join()
    with locked(policy):
        pass
    assert sorted(file.name for file in policy.parent.iterdir()) == ["p.h5", "p.h5.training"]
