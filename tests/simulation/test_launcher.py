"""How the work of a launch is cut into pieces, and by which kernel it is done."""

import threading

import pytest

from small_scene import sound_scene
from warpmuscle.kernels.objective_terms import ObjectiveKind
from warpmuscle.kernels.record import NOTHING, RecordKind
from warpmuscle.simulation import launcher, stepping
from warpmuscle.simulation.launcher import WAVES, KernelConfig, Launcher, piece_lengths, soon_loaded, spread_recipe
from warpmuscle.simulation.rollout import Rollout

RECIPE = KernelConfig(15, 8, 32, None, ObjectiveKind(), False, False, NOTHING)


@pytest.mark.parametrize("steps", [1, 7, 200])
@pytest.mark.parametrize("waves", [1.01, 1.3, 2.6, 10.3, 40.0])
def test_pieces_make_all_steps_and_waves_enough_to_fill_the_gaps_of_one_another(steps: int, waves: float):
    pieces = piece_lengths(steps, waves)
    assert sum(pieces) == steps
    assert min(pieces) >= 1
    assert max(pieces) - min(pieces) <= 1
    assert len(pieces) == steps or len(pieces) * waves >= WAVES > (len(pieces) - 1) * waves


def test_the_few_that_are_left_get_the_lanes_and_the_kernel_of_a_replay():
    replay = RECIPE._replace(lanes=16, recorded=RecordKind())
    assert [spread_recipe(RECIPE, running, 132) for running in (65536, 4096, 2560, 1)] == [None, None, replay, replay]
    assert spread_recipe(RECIPE._replace(recorded=RecordKind()), 1, 132) == replay


def test_nothing_changes_for_those_that_have_as_many_lanes_or_record_in_part():
    assert spread_recipe(RECIPE._replace(lanes=16), 1, 132) is None
    assert spread_recipe(RECIPE._replace(recorded=RecordKind(whole=False)), 1, 132) is None


class Compiled(Launcher):
    """Stands for the launcher of a kernel that Warp has in its cache, or has not."""

    cached = True

    def __init__(self, recipe: KernelConfig, device: object, threads: int) -> None:
        self.recipe, self.device = recipe, device

    @property
    def compiles(self) -> bool:
        return not self.cached

    def load(self) -> None:
        launcher._loaded.add((self.recipe, str(self.device)))


@pytest.mark.parametrize("cached", [True, False])
def test_a_kernel_is_loaded_in_the_background_but_never_compiled(cached: bool, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(launcher, "_loaded", set())
    monkeypatch.setattr(launcher, "_asked", set())
    monkeypatch.setattr(Compiled, "cached", cached)
    monkeypatch.setattr(launcher, "Launcher", Compiled)
    soon_loaded(RECIPE, "cuda:0")
    for thread in threading.enumerate():
        if thread.name == "kernel":
            thread.join()
    assert soon_loaded(RECIPE, "cuda:0") == cached


def test_a_batch_goes_on_with_the_other_kernel_once_few_are_left_and_it_is_there(monkeypatch: pytest.MonkeyPatch):
    scene = sound_scene()
    scene.duration = 0.04
    rollout = Rollout(scene, 5, "cpu")
    own = rollout._launcher
    other = Launcher(own.recipe, rollout.device, 1)
    there, launched = [False], []
    monkeypatch.setattr(Launcher, "launch", lambda self, steps, running, *_: launched.append((self, len(running))))
    monkeypatch.setattr(stepping, "spread_recipe", lambda recipe, running, _: None if running > 3 else "other")
    monkeypatch.setattr(stepping, "soon_loaded", lambda recipe, device: there[0])
    rollout._spreads, rollout._launchers["other"] = True, other
    for left, is_there in ((5, True), (3, False), (2, True)):
        rollout._running, there[0] = rollout._running[:left], is_there
        rollout.advance(rollout.steps_done + 1)
    assert launched == [(own, 5), (own, 3), (other, 2)]
