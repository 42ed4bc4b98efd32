"""What the command line says at the end of a search: that the best one stands still, and stages counted from 1."""

from dataclasses import replace
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from small_result import march, search_result, walk_scene, with_arrays
from warpmuscle.cli import console
from warpmuscle.cli import optimize as command
from warpmuscle.cli import sweep as sweeps
from warpmuscle.cli.optimize import _print_result, stands_still
from warpmuscle.cli.progress_bar import ProgressBar
from warpmuscle.formats import load, toml
from warpmuscle.gait import muscle_effort
from warpmuscle.gait.measures import measure
from warpmuscle.optimization.best_scene import recorded_scene
from warpmuscle.optimization.progress import Progress
from warpmuscle.plots import plot
from warpmuscle.report.summary import convergence
from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Best, History, Result, SearchOptions, Staged
from warpmuscle.scene import Objective, SearchStage
from warpmuscle.sweep.board import SweepProgress


def walking(speed: float) -> Recording:
    """A motion of this speed, m/s."""
    motion = march(walk_scene().character, speed, 4.0, 401, 56)
    return with_arrays(motion, com_velocity=np.tile([0.0, 0.0, speed], (401, 1)))


@pytest.mark.parametrize(("speed", "still"), [(0.0, True), (0.01, True), (1.1, False), (-1.1, False)])
def test_a_search_says_when_its_best_one_stands_still(speed: float, still: bool, capsys: pytest.CaptureFixture[str]):
    result = replace(search_result(), replays=(walking(speed),))
    _print_result(result, ProgressBar(), walk_scene(), recorded_scene(result))
    assert ("the best one stands still" in capsys.readouterr().out) == still


@pytest.mark.parametrize(("strategy", "complete", "told"), [("cma", 0, True), ("cma", 4, False), ("random", 0, False)])
def test_a_search_without_a_whole_generation_says_that_it_learnt_nothing(
    strategy: str, complete: int, told: bool, capsys: pytest.CaptureFixture[str]
):
    result = search_result()
    assert result.searched is not None
    rows = {name: getattr(result.searched.history, name)[:complete] for name in History.__dataclass_fields__}
    searched = replace(result.searched, options=SearchOptions(strategy), history=History(**rows))
    _print_result(replace(result, searched=searched), ProgressBar(), walk_scene(), recorded_scene(result))
    assert ("nothing has been learnt" in capsys.readouterr().out) == told


@pytest.mark.parametrize(
    ("strategy", "sigma", "found", "told"),
    [("cma", None, 0, True), ("cma", 0.05, 0, False), ("random", None, 0, False), ("cma", None, 3, False)],
)
def test_who_finds_nothing_better_with_usual_steps_is_told_of_smaller_ones(
    strategy: str, sigma: float | None, found: int, told: bool, capsys: pytest.CaptureFixture[str]
):
    result = search_result()
    assert result.searched is not None
    assert result.evaluations is not None
    searched = replace(result.searched, options=SearchOptions(strategy, sigma=sigma))
    values = result.evaluations.params[found]
    parameters = replace(result.parameters, value=result.evaluations.params[0])
    changed = replace(result, searched=searched, parameters=parameters, best=Best(values, 1.0, found))
    _print_result(changed, ProgressBar(), walk_scene(), recorded_scene(result))
    assert ("nothing is better than the scene as given" in capsys.readouterr().out) == told


@pytest.mark.parametrize(
    ("alive", "evaluated", "state"),
    [(0, 0, ""), (7, 0, "7 alive"), (0, 3, "best 2 of a"), (7, 3, "7 alive, best 2 of a")],
)
def test_progress_of_a_sweep_says_what_it_knows(
    alive: int, evaluated: int, state: str, monkeypatch: pytest.MonkeyPatch
):
    shown: list[str] = []
    bar = sweeps._Bar()
    monkeypatch.setattr(bar, "show", lambda part, done, state: shown.append(state))
    bar.update(SweepProgress(4, 1, 40, evaluated, 2.0, "a", alive))
    assert shown == [state]


def test_who_is_to_stand_is_not_told_of_standing():
    scene = walk_scene()
    gait = measure(walking(0.0), "lFoot", "rFoot")
    standing = msgspec.structs.replace(scene, objective=Objective(target_speed=0.0, speed=1.0))
    assert stands_still(scene, gait)
    assert not stands_still(standing, gait)


def staged() -> Result:
    """The result of a search as if it had had two stages, the second one begun."""
    result = search_result()
    scene = msgspec.structs.replace(walk_scene(), stages=[SearchStage("stand"), SearchStage("walk")])
    assert result.evaluations is not None
    assert result.searched is not None
    assert result.best is not None
    stage = np.where(np.arange(len(result.evaluations)) < 30, 0, 1)
    best = Best(result.best.params, result.best.cost, result.best.index)
    stages = tuple(Staged(name, ("a",), SearchOptions("cma"), "its end", best) for name in ("stand", "walk"))
    return replace(
        result,
        scene=toml.dumps(scene),
        evaluations=replace(result.evaluations, stage=stage),
        searched=replace(result.searched, stages=stages, stage=1),
    )


def test_stages_are_counted_from_one_in_progress_report_and_figure(monkeypatch: pytest.MonkeyPatch):
    shown: list[str] = []
    bar = ProgressBar()
    monkeypatch.setattr(bar, "show", lambda part, done, state: shown.append(state))
    bar.update(Progress(10, 5, 5, 1.0, 1.0, 0.5, 1, 1.0, 0, stage=1, stages=2, stage_name="walk"))
    assert "stage 2/2, walk" in shown[0]
    lines = convergence(staged())
    for words in ("stage 1, stand: 30 candidates", "stage 2, walk: 30 candidates"):
        assert any(line.startswith(words) for line in lines)
    figure = plot(staged(), "convergence")
    assert [axes.get_title(loc="left") for axes in figure.axes][:2] == ["Stage 1: stand", "Stage 2: walk"]


def test_what_prints_walks_is_prepared_once_while_a_kernel_is_compiled_or_a_gpu_computes(
    monkeypatch: pytest.MonkeyPatch,
):
    imported, told = [], []
    monkeypatch.setattr("warpmuscle.core.machine.cores", lambda: 2)
    effort = SimpleNamespace(load_kernel=imported.append)
    monkeypatch.setattr(console, "import_module", lambda name: imported.append(name) or effort)
    monkeypatch.setattr(
        "warpmuscle.simulation.devices.find_devices", lambda name: [SimpleNamespace(is_cpu=name == "cpu")]
    )
    ready, scene = Progress(100, 0, 0, np.inf, 0.0, 0.0, 0, np.inf, 0), load("fwalk")
    for device, count in (("cpu", 0), (None, 1)):
        printer = console.GaitPrinter(scene, (command.BEST,))
        tell = command._printing(told.append, printer, device)
        tell(ready)
        printer.end()
        assert not imported  # the kernel is not made yet, for which the processor is needed
        for alive in (3, 2):
            tell(replace(ready, alive=alive))
        printer.end()
        assert imported == count * ["warpmuscle.gait.muscle_effort", scene, "warpmuscle.gait.measures", command.BEST]
    imported.clear()
    printer = console.GaitPrinter(scene)
    command._printing(told.append, printer, "cpu")(replace(ready, compiling=True))
    printer.end()
    assert len(imported) == 3
    assert [progress.alive for progress in told] == [0, 3, 2, 0, 3, 2, 0]


def test_nothing_is_prepared_for_a_scene_without_feet_or_on_one_core(monkeypatch: pytest.MonkeyPatch):
    imported = []
    monkeypatch.setattr(console, "import_module", imported.append)
    monkeypatch.setattr("warpmuscle.core.machine.cores", lambda: 2)
    printer = console.GaitPrinter(load("throw"))
    printer.begin()
    printer.end()
    monkeypatch.setattr("warpmuscle.core.machine.cores", lambda: 1)
    printer = console.GaitPrinter(load("fwalk"))
    printer.begin()
    printer.end()
    assert not imported


def test_a_kernel_is_loaded_for_scenes_whose_muscles_have_costs(monkeypatch: pytest.MonkeyPatch):
    loaded = []
    monkeypatch.setattr(
        muscle_effort, "_kernel", lambda scene, names: loaded.append((scene.name, len(names))) or kernel
    )
    kernel = SimpleNamespace(module=SimpleNamespace(load=lambda *where: loaded.append(where)))
    for name in ("fwalk", "walk56_legacy", "walk56"):
        muscle_effort.load_kernel(load(name))
    assert loaded == [("walk56", 56), ("cpu", 1)]
