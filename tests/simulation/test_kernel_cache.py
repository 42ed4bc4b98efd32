"""A kernel counts as compiled once Warp has it in its cache, and a search says so when it has to be compiled."""

import msgspec
import pytest
import warp as wp

from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.simulation import kernel_cache
from warpmuscle.simulation.rollout import Rollout


@pytest.fixture
def scene():
    return msgspec.structs.replace(load("fwalk"), duration=0.05)


def test_a_kernel_that_has_been_run_is_compiled(scene):
    rollout = Rollout(scene, 1, "cpu", threads=1)
    rollout.run()
    assert not rollout.compiles


def test_a_kernel_in_no_cache_is_yet_to_be_compiled(scene, monkeypatch, tmp_path):
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(tmp_path))
    rollout = Rollout(scene, 1, "cpu", threads=1)
    assert rollout.compiles
    told = []
    optimize(scene, 4, device="cpu", progress=told.append)
    assert [progress.compiling for progress in told].count(True) == 1


def test_a_search_with_a_kernel_from_the_cache_does_not_speak_of_compiling(scene):
    Rollout(scene, 1, "cpu", threads=1).load()
    told = []
    optimize(scene, 4, device="cpu", progress=told.append)
    assert not any(progress.compiling for progress in told)
    assert told


def test_who_wants_to_know_is_told_what_is_compiled_and_when_that_is_done(scene, monkeypatch, tmp_path):
    heard = []

    def listener(what: str):
        heard.append(what)
        return lambda: heard.append("done")

    monkeypatch.setattr(kernel_cache, "_listeners", [])
    kernel_cache.tell_of_compiling(listener)
    kernel_cache.tell_of_compiling(listener)
    with kernel_cache.told_of_compiling("joints for cpu"):
        assert heard == ["joints for cpu"]
    assert heard == ["joints for cpu", "done"]
    Rollout(scene, 1, "cpu", threads=1).load()
    Rollout(scene, 1, "cpu", threads=1).load()
    heard.clear()
    Rollout(scene, 1, "cpu", threads=1).load()  # from the cache
    assert heard == []
