"""The exported page in a real browser without a network: what it holds, plays and draws."""

import base64
import io
import json
import re
import zlib
from importlib.resources import files
from typing import Any

import msgspec
import numpy as np
import pytest
from PIL import Image

from biped import random_recording
from patience import until
from small_result import march, walk_scene
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.scene import Ground, Objective
from warpmuscle.view import page as pages
from warpmuscle.view.page import Page, iframe, replay_html
from warpmuscle.view.sources import Sight, of_scene, page_of_sights


@pytest.fixture(scope="module")
def walk() -> Sight:
    return of_scene(msgspec.structs.replace(load("walk56"), duration=0.6), "cpu")[0]


RESET = """() => { const now = warpmuscle.state();
    document.querySelector('dialog[open]')?.close();
    document.activeElement.blur(); // else keys are letters of the search box
    document.querySelector('#options[aria-expanded=true]')?.click();
    document.getElementById('strip').scrollTop = 0;
    for (const [name, on] of Object.entries(first.shown)) if (now.shown[name] !== on) warpmuscle.show(name, on);
    warpmuscle.overlay(false); warpmuscle.setSpeed(1); warpmuscle.choose(0); warpmuscle.group(first.group);
    warpmuscle.look('oblique'); warpmuscle.seek(0); warpmuscle.play(true); }"""


@pytest.fixture(scope="module")
def page_of_two(browser, walk, tmp_path_factory):
    """The page of two motions, opened from a file by a browser that is offline, and what went wrong in it."""
    path = tmp_path_factory.mktemp("page") / "walk.html"
    path.write_text(
        page_of_sights([walk, Sight("other", walk.recording.window(0.0, 0.3), walk.scene)], "two <walks>").text
    )
    # What waits for a condition evaluates text in the page, which its policy forbids; that is tested below.
    context = browser.new_context(viewport={"width": 640, "height": 480}, offline=True, bypass_csp=True)
    page = context.new_page()
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda request: problems.append(request.url) if not request.url.startswith("file:") else None)
    page.goto(path.as_uri())
    page.evaluate("warpmuscle.ready.then(() => { window.first = warpmuscle.state(); })")
    yield page, problems
    context.close()


@pytest.fixture
def opened(page_of_two):
    """That page, as it was when it was opened."""
    page, problems = page_of_two
    page.evaluate(RESET)
    yield page
    assert not problems


def state(page: Any) -> dict[str, Any]:
    return page.evaluate("warpmuscle.state()")


def drawn(page: Any) -> dict[str, Any]:
    """The state after another picture."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return state(page)


def test_page_plays_scrubs_steps_and_shows_what_the_recording_holds(opened, walk):
    assert opened.title() == "two <walks>"
    assert state(opened)["playing"]
    before = state(opened)["pictures"]
    opened.wait_for_function(f"warpmuscle.state().pictures > {before + 3} && warpmuscle.state().time > 0.02")
    opened.click("#play")
    opened.locator("#time").fill("0.5")
    now = state(opened)
    assert (now["playing"], now["bipeds"], now["frames"]) == (False, 2, 30)
    assert now["time"] == pytest.approx(0.5 * now["end"], abs=1e-3)
    frame = np.searchsorted(walk.recording.time, now["time"])
    offset = np.array([0.65, 0.0, 0.0])  # of the left one of two
    np.testing.assert_allclose(np.array(now["com"]) - offset, walk.recording.com[frame], atol=0.02)
    opened.click("#ahead")
    once = state(opened)["time"]
    opened.click("#ahead")
    opened.click("#back")
    opened.click("#back")
    assert once - state(opened)["time"] == pytest.approx(0.02, abs=1e-4)
    opened.select_option("#speed", "0.25")
    assert state(opened)["speed"] == 0.25


def opened_options(page: Any) -> None:
    """Have the list of what is shown open."""
    if page.get_attribute("#options", "aria-expanded") != "true":
        page.click("#options")


def test_page_shows_and_hides_muscles_forces_and_desired_pose(opened):
    opened.evaluate("warpmuscle.play(false); warpmuscle.seek(0.3); warpmuscle.fit()")
    opened_options(opened)
    whole = picture_of(opened)
    for name in ("muscles", "skin", "bones", "ground forces"):
        opened.get_by_label(name).uncheck()
        without = picture_of(opened)
        assert np.mean(np.any(without != whole, axis=-1)) > 1e-4, name
        opened.get_by_label(name).check()
    np.testing.assert_array_equal(picture_of(opened), whole)
    for name in ("desired pose", "contact shapes", "thickness by force", "blue to yellow", "dark stage"):
        opened.get_by_label(name).check()
        assert np.mean(np.any(picture_of(opened) != whole, axis=-1)) > 1e-3, name
        opened.get_by_label(name).uncheck()
    marks = drawn(opened)["counts"]["marks"]
    opened.get_by_label("centre of mass").check()
    assert drawn(opened)["counts"]["marks"] > marks
    opened.get_by_label("centre of mass").uncheck()
    opened.get_by_label("follow").uncheck()
    place = drawn(opened)["target"]
    opened.evaluate("warpmuscle.seek(0.4)")
    assert drawn(opened)["target"] == place
    opened.get_by_label("follow").check()
    assert drawn(opened)["target"] != place


def test_all_of_a_motion_is_in_the_picture_whenever_it_is_looked_at(opened):
    """The place of the camera hangs on the whole motion, not on the pose at the time."""
    opened.evaluate("warpmuscle.play(false)")
    cameras = []
    for time in (0.0, 0.2, 0.4):
        opened.evaluate(f"warpmuscle.seek({time}); warpmuscle.fit()")
        cameras.append(state(opened)["camera"])
    for camera in cameras[1:]:
        assert camera["distance"] == pytest.approx(cameras[0]["distance"], abs=1e-3)
        assert camera["target"][1] + camera["pan"][1] == pytest.approx(
            cameras[0]["target"][1] + cameras[0]["pan"][1], abs=1e-3
        )


def picture_of(page: Any) -> Any:
    """The scene's pixels (H, W, 3), without what lies over it."""
    drawn(page)
    shot = page.locator("#scene").screenshot(style="#tools, #toggles, #legend, #labels { visibility: hidden }")
    return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB")).astype(int)


def test_keys_play_step_look_and_are_listed(opened):
    opened.evaluate("warpmuscle.play(false)")
    opened.evaluate("warpmuscle.seek(0)")
    opened.keyboard.press("ArrowRight")
    opened.keyboard.press("Shift+ArrowRight")
    assert state(opened)["time"] == pytest.approx(11 * 0.02, abs=1e-3)
    opened.keyboard.press("End")
    assert state(opened)["time"] == state(opened)["end"]
    opened.keyboard.press("Space")
    assert state(opened)["playing"]
    opened.keyboard.press("Space")
    for key, name in (("m", "muscles"), ("b", "flesh"), ("w", "bones"), ("g", "forces"), ("p", "plots")):
        before = state(opened)["shown"][name]
        opened.keyboard.press(key)
        assert state(opened)["shown"][name] is not before
        opened.keyboard.press(key)
    opened.keyboard.press("2")
    assert state(opened)["camera"]["yaw"] == 0.0
    opened.keyboard.press("]")
    assert state(opened)["selected"] == 1
    opened.keyboard.press("/")
    opened.keyboard.type("m 2")  # these are letters of the search box
    assert (state(opened)["words"], state(opened)["camera"]["yaw"]) == ("m 2", 0.0)
    opened.keyboard.press("Escape")
    opened.keyboard.press("?")
    assert opened.locator("#help").is_visible()
    assert "see all" in opened.locator("#help").text_content()


def test_a_page_that_is_a_file_does_nothing_that_its_own_policy_forbids(browser, walk, tmp_path):
    path = tmp_path / "walk.html"
    path.write_text(page_of_sights([walk], "walk").text)
    assert "default-src 'none'" in path.read_text()
    page, refused = browser.new_page(offline=True), []
    page.on("console", lambda message: refused.append(message.text) if message.type == "error" else None)
    page.goto(path.as_uri())
    page.evaluate("warpmuscle.ready")
    drawn(page)
    page.close()
    assert refused == []


def test_all_bipeds_are_in_the_picture_at_any_size(browser, walk, tmp_path):
    path = tmp_path / "floating.html"
    floating = msgspec.structs.replace(walk.scene, ground=Ground(stiffness=0.0))  # without a ground and its shadows
    path.write_text(page_of_sights([Sight(name, walk.recording, floating) for name in ("one", "two")]).text)
    page = browser.new_page(offline=True)
    page.goto(path.as_uri())
    page.evaluate("warpmuscle.ready.then(() => { warpmuscle.play(false); warpmuscle.show('path', false); })")
    page.evaluate("warpmuscle.show('forces', false)")
    for width, height in ((450, 320), (390, 844), (800, 250)):
        page.set_viewport_size({"width": width, "height": height})
        for view in ("side", "front", "top", "oblique"):
            page.evaluate(f"warpmuscle.look('{view}')")
            shown = picture_of(page)
            rows, columns = np.nonzero(np.any(np.abs(shown - shown[0, 0]) > 12, axis=-1))
            assert 0 < columns.min() <= columns.max() < shown.shape[1] - 1, (width, view)
            assert 0 < rows.min() <= rows.max() < shown.shape[0] - 1, (width, view)
            assert max(np.ptp(columns) / shown.shape[1], np.ptp(rows) / shown.shape[0]) > 0.4, (width, view)
    page.close()


def test_pointing_at_a_muscle_names_it_and_a_click_shows_its_curves(opened):
    opened.evaluate("warpmuscle.play(false); warpmuscle.seek(0.3); warpmuscle.look('side')")
    drawn(opened)
    found = opened.evaluate("""() => { const c = document.getElementById('scene');
        for (let y = 60; y < c.clientHeight - 10; y += 3) for (let x = 5; x < 0.6 * c.clientWidth; x += 3) {
            const one = warpmuscle.pickAt(x, y); if (one && one.muscle !== undefined) return [x, y, one.name]; }
        return null; }""")
    x, y, name = found
    opened.locator("#scene").hover(position={"x": x, "y": y})
    assert opened.locator("#tip").text_content().startswith(("walk56", "other"))
    assert name in opened.locator("#tip").text_content()
    assert "activation 0." in opened.locator("#tip").text_content()
    opened.locator("#scene").click(position={"x": x, "y": y})
    now = state(opened)
    assert (now["words"], now["panels"] >= 3) == (name, True)


def test_curves_are_found_by_name_and_laid_over_one_another(opened):
    opened.evaluate("warpmuscle.play(false)")
    opened.fill("#search", "knee DESIRED torques")
    assert (state(opened)["panels"], state(opened)["curves"]) == (1, 2)
    opened.locator("#several input").check()
    assert (state(opened)["panels"], state(opened)["curves"]) == (1, 4)
    opened.fill("#search", "nothing of that name")
    assert state(opened)["panels"] == 0
    drawn(opened)
    opened.fill("#search", "")
    assert state(opened)["panels"] > 5


def test_address_asks_for_a_frame_without_controls_and_gives_the_same_bytes(browser, walk, tmp_path):
    path = tmp_path / "walk.html"
    path.write_text(page_of_sights([walk]).text)
    shots = []
    for _ in range(2):
        page = browser.new_page(viewport={"width": 240, "height": 180})
        page.goto(f"{path.as_uri()}?frame=12&shot=1&view=side")
        page.evaluate("warpmuscle.ready")
        now = drawn(page)
        assert (now["frame"], now["playing"], now["camera"]["pitch"]) == (12, False, 0.05)
        assert not page.locator("#tools").is_visible()
        assert page.locator("#scene").bounding_box() == {"x": 0, "y": 0, "width": 240, "height": 180}
        shots.append(page.screenshot())
        page.close()
    assert shots[0] == shots[1]


CLICK_BEFORE_A_PICTURE = """() => { warpmuscle.group('activations');
    const curves = document.getElementById('curves'), { left, top } = curves.getBoundingClientRect();
    curves.dispatchEvent(new PointerEvent('pointerdown', { clientX: left + 150, clientY: top + 60, buttons: 1 }));
    return warpmuscle.state().time; }"""
COLOURS = """() => { const c = document.getElementById('curves');
    return new Set(c.getContext('2d').getImageData(0, 0, c.width, c.height).data).size; }"""


def test_curves_follow_the_cursor_and_set_it(opened):
    opened.evaluate("warpmuscle.play(false)")
    opened.click("text=activations")
    now = state(opened)
    assert (now["group"], now["panels"]) == ("activations", 30)
    opened.select_option("#selected", "1")
    assert state(opened)["frames"] == 16
    opened.click("text=ground forces >> nth=-1")
    strip = opened.locator("#curves").bounding_box()
    opened.mouse.click(strip["x"] + 150, strip["y"] + 60)
    assert 0.1 < state(opened)["time"] < 0.5
    opened.evaluate("warpmuscle.seek(0)")
    assert opened.evaluate(CLICK_BEFORE_A_PICTURE) > 0.1
    drawn(opened)  # the cursor is set at once, the strip is drawn with the next picture
    assert opened.evaluate(COLOURS) > 10


OTHER_CURVES_AT_EACH_PICTURE = f"""async () => {{ const found = [];
    for (const name of ['angles', 'activations', 'torques', 'angles']) {{
        warpmuscle.group(name);
        await new Promise((done) => requestAnimationFrame(done));
        found.push(({COLOURS})()); }}
    return found; }}"""
SCROLLED_JUST_AFTER_A_PICTURE = """async () => { warpmuscle.group('activations');
    await new Promise((done) => requestAnimationFrame(done));
    const strip = document.getElementById('strip'), before = document.getElementById('curves').toDataURL();
    strip.scrollTop = strip.scrollHeight;
    return before; }"""


def test_curves_come_with_the_next_pictures_also_where_a_motion_that_plays_stands_still(opened):
    """As one does whose simulation is late; while it plays, curves are drawn more seldom than the rest."""
    opened.evaluate("warpmuscle.play(true); warpmuscle.setSpeed(0)")
    assert min(opened.evaluate(OTHER_CURVES_AT_EACH_PICTURE)) > 10
    before = opened.evaluate(SCROLLED_JUST_AFTER_A_PICTURE)
    until(lambda: opened.evaluate("document.getElementById('curves').toDataURL()") != before)


def test_places_are_those_of_the_last_picture(opened):
    opened.evaluate("warpmuscle.play(false); warpmuscle.seek(0.1)")
    before = drawn(opened)["places"]
    assert opened.evaluate("(warpmuscle.seek(0.5), warpmuscle.state().places)") == before


def test_picture_shows_figure_ground_and_muscles(opened, tmp_path):
    opened.evaluate("warpmuscle.play(false); warpmuscle.seek(0.3)")
    drawn(opened)
    shot = opened.locator("#scene").screenshot(path=tmp_path / "scene.png")
    count = """async (png) => { const i = new Image(); i.src = 'data:image/png;base64,' + png; await i.decode();
        const c = document.createElement('canvas'); c.width = i.width; c.height = i.height;
        const pen = c.getContext('2d'); pen.drawImage(i, 0, 0);
        const d = pen.getImageData(0, 0, c.width, c.height).data; let blue = 0;
        for (let k = 0; k < d.length; k += 4) if (d[k + 2] > d[k + 1] + 50 && d[k] < 100) blue++;
        return blue; }"""
    assert opened.evaluate(count, base64.b64encode(shot).decode()) > 50  # pixels of relaxed muscles


def test_many_bipeds_are_drawn_whole_but_coarsely(browser, walk, tmp_path):
    path = tmp_path / "many.html"
    path.write_text(page_of_sights([walk] * 16).text)
    page = browser.new_page(viewport={"width": 480, "height": 320}, offline=True)
    page.goto(path.as_uri())
    page.evaluate("warpmuscle.ready.then(() => { warpmuscle.play(false); warpmuscle.seek(0.3); })")
    now = drawn(page)
    segments = len(walk.scene.character.muscles) * 16
    assert now["bipeds"] == 16
    assert now["counts"]["muscles"] >= segments
    assert now["counts"]["flesh"] > 10 * 16
    assert {now["counts"][layer] % 16 for layer in ("flesh", "bone", "shape", "muscles")} == {0}
    shot = Image.open(io.BytesIO(page.locator("#scene").screenshot())).convert("RGB")
    page.close()
    colors = np.asarray(shot).reshape(-1, 3).astype(int)
    assert np.sum((colors[:, 2] > colors[:, 0] + 60) & (colors[:, 2] > colors[:, 1] + 30)) > 50  # relaxed muscles, blue


def test_page_names_no_other_file_and_is_small(walk):
    text = replay_html(walk.recording, load("walk56"), autoplay=False)
    assert not re.search(r"""(?:src|href)\s*=|@import|url\(|https?://(?!www\.w3\.org)|import\(""", text)
    assert len(text) < 340_000  # of which bones are 120 kB, and tendons on to them 3; packed numbers differ by machine
    twice = content_of(replay_html([walk.recording] * 2, walk.scene, ["a", "b"]))
    assert [track["label"] for track in twice["tracks"]] == ["a", "b"]
    assert (len(twice["dolls"]), len(twice["panels"])) == (1, 1)  # what is alike is there once


def test_a_long_motion_has_fewer_frames_rather_than_a_large_page(walk):
    whole = replay_html(walk.recording, walk.scene)
    fixed = len(replay_html(walk.recording.at(slice(0, 1)), walk.scene))
    room = fixed + (len(whole) - fixed) // 2
    text = replay_html(walk.recording, walk.scene, largest=room)
    frames = [content_of(page)["tracks"][0]["frames"] for page in (whole, text)]
    assert len(text) <= room < len(whole)
    assert 2 <= frames[1] < frames[0] == 30


def content_of(text: str) -> Any:
    packed = re.search(r'id="content">([^<]*)</script>', text)
    return json.loads(zlib.decompress(base64.b64decode(packed[1])))


def test_page_stands_within_others(browser, walk, tmp_path):
    page = Page(replay_html(walk.recording, walk.scene, labels=['"quoted" & <odd>']))
    notebook = browser.new_page()
    notebook.set_content(f"<p>a cell</p>{page._repr_html_()}")
    notebook.wait_for_function("frames[0].warpmuscle && frames[0].warpmuscle.ready")
    inner = notebook.frames[1].evaluate("warpmuscle.ready.then(() => warpmuscle.state())")
    assert inner["frames"] == 30
    notebook.close()
    assert iframe('<p title="x">') == iframe('<p title="x">', 620)
    assert '"<p' not in iframe('<p title="x">')
    page.save(tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text() == page.text
    with pytest.raises(Error, match="folder does not exist"):
        page.save(tmp_path / "nowhere" / "a.html")


def test_motion_of_another_character_is_refused(walk):
    with pytest.raises(Error, match="another character"):
        replay_html(random_recording(), walk.scene)


def test_pictures_of_the_page_have_names():
    text = (files("warpmuscle.view") / "assets" / "page.html").read_text(encoding="utf-8")
    canvases = re.findall(r"<canvas[^>]*>", text)
    assert len(canvases) >= 2
    assert [one for one in canvases if "aria-label=" not in one] == []


def test_a_figure_is_made_once_for_scenes_that_differ_in_how_they_are_judged(monkeypatch):
    made = []
    monkeypatch.setattr(pages, "_drawn", {})
    figure = pages.figure_of
    monkeypatch.setattr(pages, "figure_of", lambda *arguments: (made.append(1), figure(*arguments))[1])
    scene = walk_scene()
    motion = march(scene.character, 1.0, 0.5, 51, 56)
    judged = msgspec.structs.replace(scene, objective=Objective(speed=3.0))
    alike = replay_html([motion, motion], [scene, judged])
    assert len(made) == 1
    shape = msgspec.structs.replace(next(iter(scene.character.bodies.values())), mass=99.0)
    bodies = scene.character.bodies | {next(iter(scene.character.bodies)): shape}
    heavier = msgspec.structs.replace(scene, character=msgspec.structs.replace(scene.character, bodies=bodies))
    replay_html([motion, motion], [scene, heavier])
    replay_html([motion, motion], [heavier, scene])
    assert len(made) == 2  # both are kept
    monkeypatch.setattr(pages, "DRAWN", 1)
    replay_html([motion, motion], [scene, heavier])
    replay_html([motion, motion], [scene, heavier])
    assert len(made) == 5  # but no more than so many: the first one was, and is not any more
    assert len(alike) > 1000


def test_a_figure_drawn_meanwhile_is_that_of_the_page(walk, monkeypatch):
    """It is drawn once, and the page is the same to the bit."""
    monkeypatch.setattr(pages, "_drawn", {})
    usual, (made, count) = replay_html(walk.recording, walk.scene), (pages.look_of, [])
    monkeypatch.setattr(pages, "_drawn", {})
    monkeypatch.setattr(pages, "look_of", lambda *given: count.append(given) or made(*given))
    with pages.drawn_meanwhile(walk.recording, walk.scene):
        pass
    assert len(count) == 1
    assert replay_html(walk.recording, walk.scene) == usual
    assert len(count) == 1


def test_what_cannot_be_drawn_meanwhile_is_said_by_the_page(walk):
    with pages.drawn_meanwhile(walk.recording, load("throw")):
        pass
    with pytest.raises(Error):
        replay_html(walk.recording, load("throw"))
