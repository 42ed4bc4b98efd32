"""Replays of candidates, made ready in the background where a GPU is busy meanwhile."""

import threading

import numpy as np
import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import Error
from warpmuscle.optimization import replay
from warpmuscle.optimization.replay import Replayer
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values
from warpmuscle.simulation.rollout import Rollout

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


class BusyDevice:
    """Stands for a GPU, on which one waits for results while other things can be done."""

    is_cpu = False

    def __str__(self) -> str:
        return "cpu"


@pytest.fixture
def scene() -> Scene:
    found = sound_scene()
    found.failure.max_com_speed = 1000.0  # it starts deep in the ground, which throws it up
    found.duration = 0.02
    return found


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the threads in which rollouts are made."""
    threads: list[str] = []

    class Noted(Rollout):
        def __init__(self, *args: object, **options: object) -> None:
            threads.append(threading.current_thread().name)
            super().__init__(*args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(replay, "Rollout", Noted)
    return threads


def test_what_is_prepared_gives_the_same_motion_and_is_made_once(
    scene: Scene, made: list[str], monkeypatch: pytest.MonkeyPatch
):
    plain, parts = Replayer(scene, "cpu").replay(start_values(scene))
    monkeypatch.setattr(replay, "find_devices", lambda _: [BusyDevice()])
    player = Replayer(scene)
    for _ in range(3):
        player.prepare()
    again, same = player.replay(start_values(scene))
    assert [name.startswith("replay") for name in made] == [False, True]
    np.testing.assert_array_equal(again.root_position, plain.root_position)
    assert same == parts


def test_on_a_cpu_which_is_busy_itself_nothing_is_prepared(scene: Scene, made: list[str]):
    player = Replayer(scene, "cpu")
    player.prepare()
    assert made == []
    assert len(player.replay(start_values(scene))[0].time) > 1


def test_an_error_in_the_background_comes_where_the_replay_is_asked_for(scene: Scene, monkeypatch: pytest.MonkeyPatch):
    def refuse(*args: object, **options: object) -> None:
        raise Error("no memory")

    monkeypatch.setattr(replay, "find_devices", lambda _: [BusyDevice()])
    monkeypatch.setattr(replay, "Rollout", refuse)
    player = Replayer(scene)
    player.prepare()
    with pytest.raises(Error, match="no memory"):
        player.replay(start_values(scene))
