"""A kernel counts as compiled once Warp has it in its cache; what takes long is said, on a terminal."""

import ast
import io
import threading
from pathlib import Path
from types import SimpleNamespace

import msgspec
import pytest
import warp as wp

import warpmuscle as wm
import warpmuscle.kernels
from patience import MOMENT, PATIENCE, ended, for_a_moment, until
from warpmuscle.formats import load
from warpmuscle.optimization.optimize import optimize
from warpmuscle.optimization.progress import Progress
from warpmuscle.simulation import kernel_cache
from warpmuscle.simulation.kernel_cache import compiling_reported, progress_said, said
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


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def terminal(monkeypatch):
    """A terminal that lines are written on at once."""
    shown = Terminal()
    monkeypatch.setattr(kernel_cache, "sys", SimpleNamespace(stderr=shown, modules={}))
    monkeypatch.setattr(kernel_cache, "_listeners", [])
    monkeypatch.setattr(kernel_cache, "LONG", 0.01)
    monkeypatch.setattr(kernel_cache, "EACH", 0.01)
    return shown


def lines(terminal):
    return [line.rsplit(", ", 1)[0] for line in terminal.getvalue().split("\r") if line.strip()]


def test_compiling_is_said_within_what_it_is_a_part_of(terminal):
    with said("searching"):
        until(lambda: lines(terminal)[-1:] == ["searching"])
        with compiling_reported("joints"):
            until(lambda: lines(terminal)[-1] != "searching")
        until(lambda: lines(terminal)[-1] == "searching")
    shown = lines(terminal)
    assert [line for line, before in zip(shown, ["", *shown[:-1]], strict=True) if line != before] == [
        "searching", "compiling joints, once (usually 5 to 20 s)", "searching",
    ]  # fmt: skip
    assert terminal.getvalue().split("\r")[-1] == ""


def test_nothing_is_said_of_what_is_short_or_where_nobody_reads(terminal, monkeypatch):
    monkeypatch.setattr(kernel_cache, "LONG", PATIENCE)
    with said("searching"):
        pass
    monkeypatch.setattr(kernel_cache, "LONG", 0.01)
    monkeypatch.setattr(terminal, "isatty", lambda: False)
    with said("searching") as line, progress_said(None, "searching", str) as tell:
        for_a_moment()
    assert line is tell is None
    assert terminal.getvalue() == ""


def test_what_listens_says_it_alone(terminal, monkeypatch):
    heard = []
    monkeypatch.setattr(kernel_cache, "_listeners", [lambda what: heard.append(what) or (lambda: None)])
    with compiling_reported("joints"), said("searching"):
        for_a_moment()
    assert heard == ["joints"]
    assert terminal.getvalue() == ""


def test_a_failure_leaves_the_line_empty(terminal):
    def fail():
        with said("searching"):
            until(lambda: lines(terminal))
            raise RuntimeError("failed")

    with pytest.raises(RuntimeError, match="failed"):
        fail()
    assert terminal.getvalue().endswith("\r")
    assert not kernel_cache._lines


def test_a_line_that_is_just_written_when_the_work_ends_does_not_stay(terminal, monkeypatch):
    plain, writing, go_on = terminal.write, threading.Event(), threading.Event()

    def slow(words):
        writing.set()
        go_on.wait(PATIENCE)
        return plain(words)

    monkeypatch.setattr(terminal, "write", slow)
    with said("searching"):
        assert writing.wait(PATIENCE)
        threading.Timer(MOMENT, go_on.set).start()
    ended("says what goes on")
    assert "searching, " in terminal.getvalue()
    assert terminal.getvalue().split("\r")[-1] == ""


def test_a_search_from_python_says_how_far_it_is(terminal):
    with progress_said(None, "searching fwalk", Progress.in_words) as tell:
        tell(Progress(60, 26, 3, 2207.3, 1.0, 0.4, 2, 2300.0, 0))
        until(lambda: lines(terminal)[-1:] == ["searching: 26 of 60 candidates, best 2207.3"])


def test_a_run_from_python_says_what_it_does(terminal):
    wm.simulate("throw", duration=0.1)
    assert any(line.startswith(("preparing a run", "simulating throw", "compiling")) for line in lines(terminal))
    assert not kernel_cache._lines


def test_what_a_user_gives_is_told_in_place_of_a_line(terminal):
    heard = []
    with progress_said(heard.append, "searching", str) as tell:
        tell(3)
        for_a_moment()
    assert heard == [3]
    assert terminal.getvalue() == ""
