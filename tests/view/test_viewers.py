"""Replay and live simulation in a real browser: what is clicked there, and what the server's scene then holds."""

import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.view.live import Live
from warpmuscle.view.live_run import LiveRun
from warpmuscle.view.replay import Replay
from warpmuscle.view.sources import of_scene, tracks_of
from warpmuscle.view.viewer import Viewer, new_server

pytest.importorskip("viser", reason="no viser: pip install 'warpmuscle[view]'")
PATIENCE = 60.0  # s, on a busy machine


def opened(browser: Any, viewer: Viewer) -> Iterator[tuple[Any, Any]]:
    """The viewer, and a page that shows it."""
    viewer.start()
    page = browser.new_page(viewport={"width": 800, "height": 1000})
    page.set_default_timeout(1000.0 * PATIENCE)
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto(f"{viewer.url}?fixedDpr=0.3")  # few pixels, which no graphics card draws here
    page.get_by_role("button", name="Pause").wait_for()
    yield viewer, page
    page.close()
    viewer.stop()
    assert not problems


@pytest.fixture(scope="module")
def replay(browser) -> Iterator[tuple[Replay, Any]]:
    """Two bipeds on muscles, the second for half the time."""
    sight = of_scene(msgspec.structs.replace(load("walk56"), duration=0.6), "cpu")[0]
    tracks = tracks_of([sight, sight])
    yield from opened(browser, Replay(new_server("127.0.0.1", 0, "replay"), tracks, [sight.scene] * 2))


@pytest.fixture(scope="module")
def live(browser) -> Iterator[tuple[Live, Any]]:
    run = LiveRun(load("fwalk"))
    yield from opened(browser, Live(new_server("127.0.0.1", 0, "live"), run))


def until(condition: Callable[[], bool]) -> None:
    """Wait until something is so."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it never came to that"
        time.sleep(0.05)


def test_replay_plays_pauses_steps_and_scrubs(replay):
    viewer, page = replay
    before = viewer.pictures
    until(lambda: viewer.pictures > before + 5)
    page.get_by_role("button", name="Pause").click()
    until(lambda: not viewer.player.playing)
    page.get_by_role("button", name="|< start").click()
    until(lambda: viewer.player.time == 0.0)
    page.get_by_role("button", name="next >").click()
    until(lambda: viewer.frames() == [1, 1])
    box = page.get_by_label("time, s").or_(page.locator("input[type=text], input[inputmode]")).first
    box.fill("0.3")
    box.press("Enter")
    until(lambda: viewer.player.time == pytest.approx(0.3, abs=0.01))
    until(lambda: viewer.frames() == [15, 15])
    track = viewer.tracks[0]
    shapes = next(handle for handle in viewer.stage.handles["shapes"] if handle.name.endswith("box"))
    feet = [part.body for part in track.doll.parts if part.kind == "box"]
    foot = track.recording.body_position[15, feet[0]] + viewer.offsets[0]
    place = track.doll.parts[[part.kind for part in track.doll.parts].index("box")].position

    def distance() -> float:
        with viewer.lock:  # the picture may still be that of the frame before, whose world stands elsewhere
            return float(np.linalg.norm(shapes.batched_positions[0] - foot - viewer.stage.world.position))

    until(lambda: distance() <= np.linalg.norm(place) + 1e-4)
    page.get_by_role("button", name="Play").click()
    until(lambda: viewer.player.playing)


def test_replay_hides_muscles_and_shows_the_desired_pose(replay):
    viewer, page = replay
    (muscles,) = viewer.stage.handles["muscles"]
    assert muscles.visible
    assert len(muscles.batched_positions) == 2 * (len(viewer.tracks[0].doll.muscles.body) - 56)
    assert len(np.unique(muscles.batched_colors, axis=0)) > 5
    page.get_by_role("checkbox", name="muscles").click()
    until(lambda: not muscles.visible)
    assert not any(handle.visible for handle in viewer.stage.handles["desired pose"])
    page.get_by_role("checkbox", name="desired pose").click()
    until(lambda: all(handle.visible for handle in viewer.stage.handles["desired pose"]))


def test_plots_have_a_cursor_where_the_replay_stands(replay):
    viewer, _ = replay
    viewer.play(False)
    viewer.player.seek(0.2)
    until(lambda: viewer.plots.cursor == 0.2 and 0.2 in viewer.plots.handles[0].data[0])
    times, *curves, spike = viewer.plots.handles[0].data
    assert np.all(np.diff(times) >= 0.0)
    assert times[np.argmax(spike)] == 0.2
    knee = viewer.tracks[0].recording.frames
    assert len(curves) == 2
    assert len(times) == knee + 3


def test_live_biped_walks_in_real_time_and_is_pushed(live):
    viewer, page = live
    until(lambda: viewer.run.time > 0.3)
    page.get_by_role("button", name="Push", exact=True).click()
    until(lambda: len(viewer.pushes) == 1)
    np.testing.assert_allclose(np.linalg.norm(viewer.pushes[0]), 20.0)
    assert viewer.pushes[0][0] > 15.0  # to the left
    state = viewer.run.rollout.state
    steps = np.diff(state.push_steps.numpy()[0])[0]  # what that does to the walk is shown in test_live_run.py
    impulse = state.push.numpy()[0] * steps * viewer.run.scene.time_step
    np.testing.assert_allclose(impulse, viewer.pushes[0], rtol=1e-5)
    page.get_by_role("button", name="Pause").click()
    until(lambda: not viewer.playing)
    stopped = viewer.run.time
    page.get_by_role("button", name="one frame on").click()
    until(lambda: viewer.run.time == pytest.approx(stopped + 0.02))
    page.get_by_role("button", name="start again").click()
    until(lambda: viewer.run.time < 0.1)


def test_live_sliders_are_bound_by_the_parameters_and_count(live):
    viewer, _ = live
    slider = viewer.parameters["controller.pd.lKnee.kp"]
    assert (slider.min, slider.max, slider.value) == (150.0, 600.0, 300.0)
    viewer.faster.value = 0.25
    slider.value = 444.0
    body = viewer.run.rollout.names.body_of_joint("rKnee")
    # The right side follows the left.
    until(lambda: viewer.run.rollout.model.simbicon.gains.numpy()["kp"][0, body] == 444.0)
    until(lambda: viewer.run.faster == 0.25)
    viewer.faster.value = 0.0
    for beyond in (1e308, float("inf")):
        slider.value = beyond
        until(lambda: viewer.run.rollout.model.simbicon.gains.numpy()["kp"][0, body] == 600.0)
    slider.value = 300.0
    until(lambda: viewer.run.faster == 0.0)
    until(lambda: viewer.run.rollout.model.simbicon.gains.numpy()["kp"][0, body] == 300.0)


def test_live_run_starts_again_after_a_fall(live):
    viewer, _ = live
    with viewer.lock:
        viewer.run.restart()
        viewer.run.push(150.0, 1.5)
        viewer.play(True)
    fallen = False
    end = time.monotonic() + PATIENCE
    while not fallen:
        assert time.monotonic() < end
        fallen = viewer.run.status != 0
    until(lambda: viewer.run.status == 0 and viewer.run.time < 0.5)


def test_address_of_another_machine_and_missing_viser_are_one_clear_error(monkeypatch):
    with pytest.raises(Error, match=r"cannot listen at 203\.0\.113\.1: "):
        new_server("203.0.113.1", 8080, "nowhere")
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(Error, match=r"pip install 'warpmuscle\[view\]'"):
        new_server("127.0.0.1", 8080, "none")
