"""Each kind of stress shifts what it says, keeps orders that others rely on, and a test that fails is told of."""

import os
import random
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from typer.testing import CliRunner

ROOT = Path(__file__).parents[2]
if str(ROOT / "tools") not in sys.path:
    sys.path.append(str(ROOT / "tools"))

import stress  # noqa: E402


@pytest.fixture
def live(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Stands for the viewer's modules; its `told` are the calls of what they have."""
    told: list[Any] = []

    class Live:
        def advance(self, passed: float) -> None:
            told.append(passed)

        def _hear(self, message: str) -> None:
            told.append(message)

    class PageServer:
        def __init__(self) -> None:
            self._loop = SimpleNamespace(
                time=lambda: 5.0, call_at=lambda when, act, *given: told.append((when, given[1]))
            )

        def _tell(self, message: str) -> None:
            told.append(message)

        def stop(self) -> None:
            told.append("stopped")

    module = SimpleNamespace(PICTURES=30.0, time=None, Live=Live, PageServer=PageServer, told=told)
    for name in (stress.LIVE, stress.SERVER):
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.setattr(stress, "CHANCE", random.Random(1))
    return module


def begin(kind: str) -> None:
    for act in stress.KINDS[kind][1]:
        act()


def test_a_coarse_simulation_has_few_pictures_and_several_at_once(live):
    begin("coarse")
    live.Live().advance(0.1)
    assert (live.PICTURES, live.told) == (1.5, [0.1] * 3)


def test_a_quick_simulation_has_a_clock_that_runs_fast(live, monkeypatch):
    monkeypatch.setattr(stress, "time", SimpleNamespace(monotonic=lambda: 3.0))
    begin("quick")
    assert {name: clock() for name, clock in vars(live.time).items()} == {"monotonic": 12.0, "perf_counter": 12.0}


def test_what_a_server_tells_late_stays_in_order(live):
    begin("late server")
    server = live.PageServer()
    for number in range(20):
        server._tell(number)
    times, numbers = zip(*live.told, strict=True)
    assert numbers == tuple(range(20))
    assert list(times) == sorted(times)
    assert 5.0 < times[0] < times[-1] < 5.3


def test_another_order_keeps_the_tests_of_a_file_together(monkeypatch):
    monkeypatch.setattr(stress, "CHANCE", random.Random(1))
    items = [SimpleNamespace(path=path, number=number) for path in "abc" for number in range(5)]
    other = list(items)
    stress.other_order(other)
    assert other != items
    assert sorted(other, key=items.index) == items
    paths = [item.path for item in other]
    assert all(paths[k : k + 5] == [paths[k]] * 5 for k in (0, 5, 10))


@pytest.mark.parametrize(("codes", "failed"), [([0, 0], ""), ([0, 1], "failed: late page")])
def test_tests_are_run_under_each_kind_and_a_failure_is_told(codes, failed, monkeypatch):
    runs: list[Any] = []

    def run(command: list[str], env: dict[str, str], **_: Any) -> Any:
        runs.append((command[command.index("-q") + 1 :], env["STRESS"], env["STRESS_SEED"]))
        assert env["PYTHONPATH"].split(os.pathsep)[0] == str(ROOT / "tools")
        return SimpleNamespace(returncode=codes[len(runs) - 1])

    monkeypatch.setattr(subprocess, "run", run)
    done = CliRunner().invoke(
        stress.program(), ["--only", "coarse", "--only", "late page", "--seed", "7", "a.py", "-k", "b"]
    )
    assert runs == [(["a.py", "-k", "b"], kind, "7") for kind in ("coarse", "late page")]
    assert done.exit_code == bool(failed)
    assert failed in done.output


def test_a_kind_that_is_none_is_refused():
    done = CliRunner().invoke(stress.program(), ["--only", "calm"])
    assert done.exit_code == 2
    assert "no kind of stress: calm" in done.output
