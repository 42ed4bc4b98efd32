"""Replay and live simulation in a real browser: what is clicked there, and what the server's simulation then does."""

import re
import sys
from collections.abc import Iterator
from typing import Any

import msgspec
import numpy as np
import pytest

from live_viewer import MARKED, TOLD, caught_up, until, used
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.view.controls import Slider
from warpmuscle.view.live import Live
from warpmuscle.view.live_run import LiveRun
from warpmuscle.view.page import replay_html
from warpmuscle.view.sources import of_scene
from warpmuscle.view.viewer import Viewer, replay_viewer

pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
wished: list[float] = []  # values of a control of others


def opened(browser: Any, viewer: Viewer) -> Iterator[tuple[Any, Any]]:
    """The viewer, and a page that shows it."""
    viewer.start()
    page = browser.new_page(viewport={"width": 640, "height": 420})
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("console", lambda message: problems.append(message.text) if message.type == "error" else None)
    page.add_init_script(MARKED)
    page.goto(viewer.url)
    page.evaluate("warpmuscle.ready")
    yield viewer, page
    page.close()
    viewer.stop()
    viewer.wait()
    assert not problems


@pytest.fixture(scope="module")
def walking(browser) -> Iterator[tuple[Live, Any]]:
    run = LiveRun(load("fwalk"))
    yield from opened(browser, Live(run, [Slider("wish", 0.0, 2.0, 1.0, wished.append, "m/s")], port=0))


@pytest.fixture
def live(walking) -> tuple[Live, Any]:
    """A walk that has just begun, and its page, whatever another test has done to them."""
    viewer, page = walking
    assert not viewer._stopped.is_set()
    bar = viewer.bar
    begin = (bar["play"], True), (bar["speed"], "1"), (viewer.impulse, 20.0), (viewer.direction, "to the left")
    for control, value in begin:
        viewer.server.on_message(used(viewer, control, value))
    with viewer.lock:
        viewer.restart()
        pictures = viewer.pictures
    until(lambda: viewer.pictures > pictures)
    page.evaluate("warpmuscle.look('oblique')")
    caught_up(viewer, page)
    return walking


def state(page: Any) -> dict[str, Any]:
    return page.evaluate("warpmuscle.state()")


def clicked(live: tuple[Live, Any]) -> None:
    """Pause, or go on, by hand; what the page is told of that comes before it is clicked again."""
    viewer, page = live
    playing = not viewer.playing
    page.click("#play")
    until(lambda: viewer.playing is playing)
    caught_up(viewer, page)
    assert state(page)["playing"] is playing


def test_replay_is_the_page_that_can_be_exported(browser):
    sight = of_scene(msgspec.structs.replace(load("fwalk"), duration=0.3), "cpu")[0]
    text = replay_html([sight.recording] * 2, sight.scene, ["a", "b"])
    for viewer, page in opened(browser, replay_viewer(text, port=0)):
        assert page.context.request.get(viewer.url).text() == text  # its policy lets the page itself ask for nothing
        assert state(page)["bipeds"] == 2
        page.goto(f"{viewer.url}&frame=3")
        page.evaluate("warpmuscle.ready")
        assert (state(page)["frame"], state(page)["playing"]) == (3, False)


def test_live_biped_walks_in_real_time_and_what_is_shown_is_what_is_simulated(live):
    viewer, page = live
    until(lambda: viewer.run.time > 0.5 and state(page)["time"] > 0.3)
    clicked(live)
    until(lambda: state(page)["end"] == pytest.approx(viewer.run.track().recording.time[-1], abs=1e-4))
    page.evaluate("warpmuscle.seek(1e9)")
    shown = state(page)
    with viewer.lock:
        np.testing.assert_allclose(shown["com"], viewer.run.track().recording.com[-1], atol=1e-5)
    stopped = viewer.run.time
    page.click("#ahead")
    until(lambda: viewer.run.time == pytest.approx(stopped + 0.02))
    until(lambda: state(page)["end"] == pytest.approx(shown["end"] + 0.02, abs=1e-4))
    page.click("#back")
    page.click("#back")
    assert state(page)["time"] == pytest.approx(state(page)["end"] - 0.04, abs=1e-3)
    assert viewer.run.time == pytest.approx(stopped + 0.02)
    clicked(live)
    until(lambda: viewer.run.time > stopped + 0.1)
    clicked(live)  # else it may be as far again before one looks
    page.click("#again")
    until(lambda: viewer.run.time < stopped)
    until(lambda: state(page)["end"] < stopped)


def test_it_goes_from_frame_to_frame_also_where_a_page_has_missed_some(live, monkeypatch):
    viewer, page = live
    until(lambda: state(page)["end"] > 0.1)
    with monkeypatch.context() as patch:
        tell = viewer.server.tell
        patch.setattr(viewer.server, "tell", lambda message: tell(message) if isinstance(message, str) else None)
        begun = viewer.run.time
        until(lambda: viewer.run.time > begun + 1.0)
    missed = viewer.run.time
    until(lambda: state(page)["end"] > missed + 0.1)  # pictures on their way may be older
    clicked(live)
    until(lambda: state(page)["end"] == pytest.approx(viewer.run.track().recording.time[-1], abs=1e-4))
    now = state(page)
    assert now["frames"] < now["end"] / 0.02 - 20
    page.evaluate("warpmuscle.seek(1e9)")  # what is shown is behind the last frame if none came after the pause
    page.click("#back")
    page.click("#back")
    assert state(page)["time"] == pytest.approx(now["end"] - 0.04, abs=1e-3)
    page.click("#ahead")
    assert state(page)["time"] == pytest.approx(now["end"] - 0.02, abs=1e-3)


def test_what_is_sought_stays_while_pictures_are_on_their_way(live):
    viewer, page = live
    until(lambda: state(page)["end"] > 0.3)
    with viewer.lock:
        page.evaluate("warpmuscle.seek(0.1)")
        before = viewer.pictures
        viewer.advance(0.1)  # as it does once more before it hears of the pause
        assert viewer.pictures > before
    until(lambda: not viewer.playing)
    caught_up(viewer, page)
    assert state(page)["end"] > 0.3
    assert state(page)["time"] == pytest.approx(0.1)


def test_live_biped_is_pushed_and_told_by_a_slider_of_others(live):
    viewer, page = live
    before = len(viewer.pushes)
    page.get_by_role("button", name="Push", exact=True).click()
    until(lambda: len(viewer.pushes) == before + 1)
    np.testing.assert_allclose(np.linalg.norm(viewer.pushes[-1]), 20.0, rtol=1e-6)
    assert viewer.pushes[-1][0] > 15.0  # to the left
    run = viewer.run.rollout.state
    steps = np.diff(run.push_steps.numpy()[0])[0]  # what that does to the walk is shown in test_live_run.py
    impulse = run.push.numpy()[0] * steps * viewer.run.scene.time_step
    np.testing.assert_allclose(impulse, viewer.pushes[-1], rtol=1e-5)
    box = page.get_by_label("wish, number")
    box.fill("1.25")
    box.press("Enter")
    until(lambda: wished == [1.25])
    page.select_option("#speed", "0.5")
    until(lambda: viewer.speed == 0.5)
    page.select_option("#speed", "1")
    until(lambda: viewer.speed == 1.0)


HELD = """(() => { const Plain = WebSocket;
    window.WebSocket = class extends Plain {
        get readyState() { return window.isOpen ? super.readyState : Plain.CONNECTING; }
        set onopen(act) { window.letOpen = () => { window.isOpen = true; act(); }; }
    }; })()"""


def test_what_is_clicked_while_the_socket_opens_is_done_once_it_is_open(live, browser):
    """A page can be used before; what it sets for itself meanwhile is not for the other pages."""
    viewer, page = live
    page.select_option("#speed", "0.5")
    until(lambda: viewer.speed == 0.5)
    other, before = browser.new_page(viewport={"width": 640, "height": 420}), len(viewer.pushes)
    other.add_init_script(HELD)
    other.goto(viewer.url)
    other.evaluate("warpmuscle.ready")
    other.get_by_role("button", name="Push", exact=True).click()
    until(lambda: state(other)["received"] > 0)
    assert len(viewer.pushes) == before
    other.evaluate("letOpen()")
    until(lambda: len(viewer.pushes) == before + 1)
    other.close()
    assert viewer.speed == 0.5


DRAG = """([dx, dy, ctrl]) => { const scene = document.getElementById('scene'), [x, y] = warpmuscle.state().places[0];
    const at = [x * scene.clientWidth, y * scene.clientHeight], box = scene.getBoundingClientRect();
    const say = (kind, px, py) => scene.dispatchEvent(new PointerEvent(kind, { pointerId: 1, button: 0, buttons: 1,
        clientX: box.left + px, clientY: box.top + py, ctrlKey: ctrl, bubbles: true }));
    scene.setPointerCapture = () => 0;
    say('pointerdown', ...at);
    say('pointermove', at[0] + dx, at[1] + dy); say('pointerup', at[0] + dx, at[1] + dy); }"""


def test_live_biped_is_pushed_where_it_is_dragged_to(live):
    viewer, page = live
    pictures = page.evaluate("warpmuscle.look('front'); warpmuscle.state().pictures")
    until(lambda: state(page)["pictures"] > pictures)  # so that the body is where the drag begins
    before, yaw = len(viewer.pushes), state(page)["camera"]["yaw"]
    page.evaluate(DRAG, [40, 0, True])
    until(lambda: len(viewer.pushes) == before + 1)
    impulse = viewer.pushes[-1]
    assert impulse[0] > 5.0  # from the front, the right edge of the picture is the body's left
    assert abs(impulse[1]) < 1e-6
    page.locator("#push").click()
    page.evaluate(DRAG, [0, -4000, False])
    until(lambda: len(viewer.pushes) == before + 2)
    assert np.linalg.norm(viewer.pushes[-1]) == pytest.approx(100.0)
    assert state(page)["camera"]["yaw"] == yaw
    page.locator("#push").click()
    page.evaluate(DRAG, [40, 0, False])  # turns the camera
    until(lambda: state(page)["camera"]["yaw"] != yaw)
    assert len(viewer.pushes) == before + 2


def test_a_body_that_is_double_clicked_stays_in_the_middle_until_all_is_seen_again(live):
    viewer, page = live
    clicked(live)  # so that it stays where it is found
    x, y = page.evaluate("""async () => { const scene = document.getElementById('scene');
        for (const _ of [1, 2]) await new Promise(requestAnimationFrame);
        const [x, y] = warpmuscle.state().places[0], box = scene.getBoundingClientRect();
        return [box.left + x * scene.clientWidth, box.top + y * scene.clientHeight]; }""")
    page.mouse.dblclick(x, y)
    until(lambda: state(page)["followed"] != "")
    assert state(page)["followed"] in viewer.run.rollout.names.bodies
    page.keyboard.press("f")
    until(lambda: state(page)["followed"] == "")
    page.keyboard.press("t")
    yaw = state(page)["camera"]["yaw"]
    until(lambda: abs(state(page)["camera"]["yaw"] - yaw) > 0.1)
    page.keyboard.press("t")


def test_live_sliders_are_found_bound_by_the_parameters_and_count(live):
    viewer, page = live
    slider = viewer.parameters["controller.pd.lKnee.kp"]
    assert (slider.min, slider.max, slider.value) == (150.0, 600.0, 300.0)
    section = page.locator("#side details", has=page.locator("summary", has_text="Parameters"))
    if section.get_attribute("open") is None:
        section.locator("summary").click()
    section.locator("input[type=search]").fill("knee KP")
    rows = section.locator(".row:visible")
    assert rows.count() == 1
    body = viewer.run.rollout.names.body_of_joint("rKnee")

    def gain() -> float:
        with viewer.lock:
            return float(viewer.run.rollout.model.simbicon.gains.numpy()["kp"][0, body])

    for typed, taken in (("444", 444.0), ("1e300", 600.0), ("300", 300.0)):
        rows.locator("input[type=number]").fill(typed)
        page.keyboard.press("Enter")
        until(lambda taken=taken: gain() == taken)  # the right side follows the left
        caught_up(viewer, page)  # else what it is told changes what is typed next
    assert rows.locator("input[type=number]").input_value() == "300"
    assert float(rows.locator("input[type=range]").input_value()) == pytest.approx(300.0, abs=(600.0 - 150.0) / 200.0)


def test_what_one_page_moves_another_one_shows(live, browser):
    viewer, page = live
    other = browser.new_page(viewport={"width": 390, "height": 700})
    other.add_init_script(MARKED)
    other.goto(viewer.url)
    other.evaluate("warpmuscle.ready")
    until(lambda: state(other)["received"] > 0)
    page.get_by_label("impulse, number").fill("33")
    page.keyboard.press("Enter")
    until(lambda: other.get_by_label("impulse, number").input_value() == "33")
    clicked((viewer, other))
    until(lambda: not viewer.playing and not state(page)["playing"])
    clicked((viewer, other))
    until(lambda: viewer.playing and state(page)["playing"])
    assert other.evaluate("document.documentElement.scrollWidth") <= 390
    other.close()
    until(lambda: viewer.server.clients == 1)


def test_live_run_that_a_push_fells_says_so_and_starts_again(live):
    viewer, page = live
    with viewer.lock:
        viewer.impulse.value = 100.0
    page.get_by_role("button", name="Push", exact=True).click()
    status = page.locator("#status")
    until(
        lambda: re.search(r"(fell|turned) at \d+\.\d s, pushed by 100 N s to the left; begun anew", status.inner_text())
    )
    assert viewer.run.status == 0
    viewer.restart()  # by hand
    until(lambda: re.fullmatch(r"-?\d\.\d\d m/s forwards", status.inner_text()))


def test_page_says_so_when_the_simulation_ends_and_the_address_of_the_next_goes_on(browser):
    viewer = Live(LiveRun(load("fwalk")), port=0)
    viewer.start()
    page = browser.new_page(viewport={"width": 500, "height": 400})
    page.goto(viewer.url)
    page.evaluate("warpmuscle.ready")
    until(lambda: state(page)["received"] > 2)
    page.evaluate(TOLD)
    viewer.server._loop.call_soon_threadsafe(next(iter(viewer.server._clients)).transport.abort)
    until(lambda: "has ended" in str(page.evaluate("told")))
    before = state(page)["received"]
    until(lambda: state(page)["received"] > before)  # it seeks its server by itself
    until(lambda: not page.get_by_role("alert").is_visible())
    viewer.stop()
    page.get_by_role("alert").get_by_text("open the address that it prints").wait_for()
    again = Live(LiveRun(load("fwalk")), port=viewer.server.port)
    again.start()
    page.goto(again.url)
    page.evaluate("warpmuscle.ready")
    until(lambda: state(page)["received"] > 0)
    page.close()
    again.stop()


def test_address_of_another_machine_taken_ports_and_missing_websockets_are_one_clear_error(monkeypatch):
    with pytest.raises(Error, match=r"cannot listen at 203\.0\.113\.1: "):
        replay_viewer("page", "203.0.113.1", 8080)
    first = replay_viewer("page", port=0)
    second = replay_viewer("page", port=first.server.port)
    assert second.server.port > first.server.port
    first.stop()
    second.stop()
    second.stop()  # does no harm
    monkeypatch.setitem(sys.modules, "websockets.asyncio.server", None)
    with pytest.raises(Error, match=r"pip install 'warpmuscle\[view\]'"):
        replay_viewer("page", port=0)
