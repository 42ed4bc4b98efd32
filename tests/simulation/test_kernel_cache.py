"""A kernel counts as compiled once Warp has it in its cache, and a search says so when it has to be compiled."""

import ast
from pathlib import Path

import msgspec
import pytest
import warp as wp

import warpmuscle.kernels
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
    with kernel_cache.compiling_reported("joints for cpu"):
        assert heard == ["joints for cpu"]
    assert heard == ["joints for cpu", "done"]
    first, second = (kernel_cache.compiling_reported(what) for what in ("first", "second"))
    for manager in (first, second):
        manager.__enter__()
    for manager in (first, second):  # which ends before the one that began later
        assert heard[2:] == ["first"]
        manager.__exit__(None, None, None)
    assert heard[2:] == ["first", "done"]
    Rollout(scene, 1, "cpu", threads=1).load()
    Rollout(scene, 1, "cpu", threads=1).load()
    heard.clear()
    Rollout(scene, 1, "cpu", threads=1).load()  # from the cache
    assert heard == []


def test_a_kernel_is_the_same_one_with_and_without_derivatives_elsewhere(scene, monkeypatch):
    """Else a program of one's own that turns them off, as tests do, would compile each kernel a second time."""
    module = Rollout(scene, 1, "cpu", threads=1)._launcher.kernel().kernel.module
    names = set()
    for derivatives in (True, False):
        monkeypatch.setattr(wp.config, "enable_backward", derivatives)
        module.mark_modified()
        names.add(module.get_module_identifier(1))
    assert len(names) == 1


def test_modules_with_kernels_say_that_they_need_no_derivatives():
    kernels = 0
    for path in Path(warpmuscle.kernels.__file__).parent.rglob("*.py"):
        text = path.read_text()
        for node in ast.walk(ast.parse(text)):
            for decorator in getattr(node, "decorator_list", ()):
                said = ast.unparse(decorator)
                if not said.startswith("wp.kernel"):
                    continue
                kernels += 1
                own = "'unique'" in said
                assert (
                    "'enable_backward': False" in said
                    or (own and "module_options(" in said)
                    or (not own and 'wp.set_module_options({"enable_backward": False' in text)
                ), f"{path}:{node.lineno}"
    assert kernels > 40
