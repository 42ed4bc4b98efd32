"""Memory of a batch: what an instance takes is what is allocated, and too many are refused before that."""

import msgspec
import numpy as np
import pytest

from short_walks import short_walk
from small_scene import muscle_scene
from warpmuscle.core.errors import RolloutError
from warpmuscle.formats import load
from warpmuscle.optimization import evaluation
from warpmuscle.optimization.evaluation import BatchEvaluator
from warpmuscle.scene.parameters import start_values
from warpmuscle.simulation import memory
from warpmuscle.simulation.devices import free_memory
from warpmuscle.simulation.memory import struct_bytes
from warpmuscle.simulation.multi_device import MultiDeviceRollout
from warpmuscle.simulation.rollout import Rollout


def with_all_terms():
    """The small scene with muscles, sums for every kind of term, and bodies that may collide."""
    scene = muscle_scene()
    scene.objective = msgspec.structs.replace(scene.objective, metabolic=1.0, joint_limits=1.0, speed=1.0)
    return scene


@pytest.mark.parametrize("scene", [short_walk(), muscle_scene(), with_all_terms(), load("walk56")], ids=range(4))
def test_bytes_of_an_instance_are_those_that_are_allocated(scene):
    one, many = (Rollout(scene, count, "cpu", threads=1) for count in (1, 41))
    assert struct_bytes(many.state) - struct_bytes(one.state) == 40 * many.instance_bytes.state
    shared = struct_bytes(many.model)
    assert shared == struct_bytes(one.model)
    values = np.tile(start_values(scene), (41, 1)) * np.linspace(1.0, 1.001, 41)[:, None]  # rows alike would be one
    many.set_parameters(values)
    assert struct_bytes(many.model) - shared == 40 * many.instance_bytes.model
    several = MultiDeviceRollout(scene, 3, ["cpu", "cpu"])
    assert several.instance_bytes == many.instance_bytes
    assert several.held_bytes >= one.held_bytes >= many.instance_bytes.total


def test_a_million_bipeds_with_all_muscles_and_parameters_fit_a_gpu():
    needed = Rollout(load("walk56"), 1, "cpu", threads=1).instance_bytes
    assert 1_000_000 * needed.total < 0.25 * 139 * 1024**3


def test_the_memory_of_this_machine_is_known_or_said_not_to_be():
    free = free_memory(Rollout(short_walk(), 1, "cpu").device)
    assert free is None or 1024**2 < free < 2**60


def test_more_instances_than_fit_are_refused_with_the_number_that_does(monkeypatch):
    needed = Rollout(short_walk(), 1, "cpu").instance_bytes
    monkeypatch.setattr(memory, "FEW", 256)
    monkeypatch.setattr(memory, "free_memory", lambda device: 1000 * needed.state / memory.USABLE + 1.0)
    with pytest.raises(RolloutError, match=r"1001 instances need .* GiB on cpu, .* left for 1000 of .* KiB each"):
        Rollout(short_walk(), 1001, "cpu")
    assert Rollout(short_walk(), 1000, "cpu").instances == 1000


def test_parameters_of_their_own_are_refused_where_they_do_not_fit_and_leave_the_batch_as_it_was(monkeypatch):
    one, twin = (Rollout(short_walk(0.1), 300, "cpu") for _ in range(2))
    monkeypatch.setattr(memory, "FEW", 256)
    monkeypatch.setattr(memory, "free_memory", lambda device: one.instance_bytes.model)
    values = np.tile(start_values(one.scene), (300, 1)) * 1.01
    with pytest.raises(RolloutError, match="300 instances need"):
        one.set_parameters(values)
    for batch in (one, twin):
        batch.run()
    np.testing.assert_array_equal(one.cost(), twin.cost())
    monkeypatch.setattr(memory, "free_memory", lambda device: None)
    one.set_parameters(values)


def test_batches_of_an_optimisation_are_as_large_as_fits(monkeypatch):
    assert BatchEvaluator(short_walk(), "cpu", 1).largest == evaluation.CPU_BATCH
    needed = Rollout(short_walk(), 1, "cpu").instance_bytes.total
    monkeypatch.setattr(memory, "free_memory", lambda device: 2.001 * 100 * needed / memory.USABLE)
    assert BatchEvaluator(short_walk(), "cpu", 1).largest == 100
    monkeypatch.setattr(memory, "free_memory", lambda device: 0)
    assert BatchEvaluator(short_walk(), "cpu", 1).largest == 1


def test_where_there_is_room_for_more_nobody_finds_out_what_an_instance_takes(monkeypatch):
    held = Rollout(short_walk(), 1, "cpu").held_bytes
    monkeypatch.setattr(memory, "free_memory", lambda device: 2.001 * evaluation.CPU_BATCH * held / memory.USABLE)
    monkeypatch.setattr(Rollout, "instance_bytes", None)
    assert BatchEvaluator(short_walk(), "cpu", 1).largest == evaluation.CPU_BATCH
