"""The page that is open while a motion is made ready: what it shows, says, and how it gives way."""

import re

import msgspec
import numpy as np
import pytest

import patience
from warpmuscle.core.pose import multiply
from warpmuscle.formats import load
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.live import Live
from warpmuscle.view.live_run import LiveRun
from warpmuscle.view.page import replay_html
from warpmuscle.view.viewer import replay_viewer
from warpmuscle.view.waiting import Waiting, first_pose


@pytest.fixture(scope="module")
def scene():
    return msgspec.structs.replace(load("walk56"), duration=0.2)


@pytest.mark.parametrize("name", ["walk56", "bigbird_walk", "reflex_planar"])
def test_first_pose_is_the_one_that_the_simulation_starts_from(name):
    scene = load(name)
    scene.initial_state.heading = 0.7 if name == "bigbird_walk" else None
    if name == "reflex_planar":  # whose root stays in its plane, whatever the scene says
        _, y, z = scene.initial_state.root_position
        scene.initial_state.root_position = (0.5, y, z)
    numeric = substitute(scene, start_values(scene))
    pose = first_pose(numeric)
    rollout = Rollout(msgspec.structs.replace(numeric, duration=0.05), 1, "cpu", record=[0])
    rollout.run()
    start = rollout.recording()
    reach = 5.0 * scene.time_step  # m, in a step at 5 m/s
    for quantity in ("body_position", "com", "root_position"):
        np.testing.assert_allclose(getattr(pose, quantity)[0], getattr(start, quantity)[0], atol=reach)
    same = np.abs(np.sum(pose.body_orientation[0] * start.body_orientation[0], axis=-1))
    np.testing.assert_allclose(same, 1.0, atol=1e-3)
    assert pose.body_names == start.body_names
    assert multiply(pose.root_orientation[0], [0.0, 0.0, 0.0, 1.0]) == pytest.approx(pose.root_orientation[0])


@pytest.fixture
def waiting(scene, browser):
    """A waiting page in a browser that must find nothing wrong."""
    waiting = Waiting(scene, port=0)
    page = browser.new_page(viewport={"width": 400, "height": 300})
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto(waiting.server.url)
    page.evaluate("warpmuscle.ready")
    page.waiting = waiting
    yield page
    page.close()
    waiting.server.stop()
    assert not problems


def until(page, expression, holds):
    """Wait until what a page computes is as it should be; its policy has no strings run as code by itself."""
    from playwright.sync_api import Error

    def there():
        try:
            return holds(page.evaluate(expression))
        except Error as gone:  # it is being loaded anew
            if "context" not in str(gone):
                raise
            return False

    patience.until(there)


MESSAGE = "document.getElementById('message')?.textContent ?? ''"


def says(page, words):
    until(page, MESSAGE, lambda text: words in text)


def test_page_says_what_is_done_and_gives_way_to_the_motion(waiting, scene):
    now = waiting.evaluate("warpmuscle.state()")
    assert (now["bipeds"], now["frames"], now["counts"]["flesh"] > 10) == (1, 1, True)
    assert not waiting.locator("#bar").is_visible()
    waiting.waiting.say("compiling <b>56 muscles</b>")
    says(waiting, "compiling <b>56 muscles</b>")
    until(waiting, MESSAGE, lambda text: re.search(r"muscles</b>, [1-9]\d* s$", text))
    rollout = Rollout(scene, 1, "cpu", record=[0], record_rate=50.0)
    rollout.run()
    replay_viewer(replay_html(rollout.recording(), scene), server=waiting.waiting.server)
    until(waiting, "window.warpmuscle?.state?.().frames", lambda frames: frames == 10)
    assert waiting.locator("#bar").is_visible()


def test_page_gives_way_to_a_live_simulation_that_finds_it_late(waiting, scene):
    waiting.evaluate("window.before = true")
    viewer = Live(LiveRun(scene), server=waiting.waiting.server)
    viewer.start()
    until(waiting, "window.before ? 0 : window.warpmuscle?.state?.().received ?? 0", lambda received: received > 2)
    viewer.stop()


def test_page_says_what_failed(waiting):
    waiting.waiting.say("compiling")
    says(waiting, "compiling")  # so it hears its server
    waiting.waiting.fail("There is nothing to show: it fell apart")
    says(waiting, "it fell apart")
