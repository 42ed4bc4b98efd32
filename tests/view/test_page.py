"""The exported page in a real browser without a network: what it holds, plays and draws."""

import base64
import io
import re
from typing import Any

import msgspec
import numpy as np
import pytest
from PIL import Image

from biped import random_recording
from warpmuscle.core.errors import Error
from warpmuscle.formats import load
from warpmuscle.view.page import Page, iframe, replay_html
from warpmuscle.view.sources import Sight, of_scene, page_of_sights


@pytest.fixture(scope="module")
def walk() -> Sight:
    return of_scene(msgspec.structs.replace(load("walk56"), duration=0.6), "cpu")[0]


@pytest.fixture
def opened(browser, walk, tmp_path):
    """The page of two motions, opened from a file by a browser that is offline."""
    path = tmp_path / "walk.html"
    path.write_text(
        page_of_sights([walk, Sight("other", walk.recording.window(0.0, 0.3), walk.scene)], "two <walks>").text
    )
    context = browser.new_context(viewport={"width": 900, "height": 640}, offline=True)
    page = context.new_page()
    page.set_default_timeout(60_000)
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda request: problems.append(request.url) if not request.url.startswith("file:") else None)
    page.goto(path.as_uri())
    page.evaluate("warpmuscle.ready")
    yield page
    assert not problems
    context.close()


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


def test_page_shows_and_hides_muscles_forces_and_desired_pose(opened):
    opened.evaluate("warpmuscle.play(false)")
    full = drawn(opened)["counts"]
    assert full["lines"] >= 2 * 56
    opened.get_by_label("muscles").uncheck()
    without = drawn(opened)["counts"]
    assert without["lines"] <= full["lines"] - 2 * 56
    assert without["body"] + without["glass"] == full["body"] + full["glass"]
    opened.get_by_label("desired pose").check()
    assert drawn(opened)["counts"]["glass"] > without["glass"]
    opened.get_by_label("centre of mass").uncheck()
    assert drawn(opened)["counts"]["paths"] == 0
    opened.get_by_label("follow").uncheck()
    place = drawn(opened)["target"]
    opened.evaluate("warpmuscle.seek(0.4)")
    assert drawn(opened)["target"] == place
    opened.get_by_label("follow").check()
    assert drawn(opened)["target"] != place


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
    pixels = "(c) => new Set(c.getContext('2d').getImageData(0, 0, c.width, c.height).data).size"
    assert opened.locator("#curves").evaluate(pixels) > 10


def test_picture_shows_figure_ground_and_muscles(opened, tmp_path):
    opened.evaluate("warpmuscle.play(false); warpmuscle.seek(0.3)")
    drawn(opened)
    shot = opened.locator("#scene").screenshot(path=tmp_path / "scene.png")
    count = """async (png) => { const i = new Image(); i.src = 'data:image/png;base64,' + png; await i.decode();
        const c = document.createElement('canvas'); c.width = i.width; c.height = i.height;
        const pen = c.getContext('2d'); pen.drawImage(i, 0, 0);
        const d = pen.getImageData(0, 0, c.width, c.height).data; let dark = 0;
        for (let k = 0; k < d.length; k += 4) if (d[k + 2] > 90 && d[k] < 90 && d[k + 1] < 60) dark++;
        return dark; }"""
    assert opened.evaluate(count, base64.b64encode(shot).decode()) > 50  # pixels of relaxed muscles, dark blue


def test_many_bipeds_are_drawn_whole_but_coarsely(browser, walk, tmp_path):
    path = tmp_path / "many.html"
    path.write_text(page_of_sights([walk] * 64).text)
    page = browser.new_page(viewport={"width": 600, "height": 500}, offline=True)
    page.set_default_timeout(60_000)
    page.goto(path.as_uri())
    page.evaluate("warpmuscle.ready.then(() => { warpmuscle.play(false); warpmuscle.seek(0.3); })")
    now = drawn(page)
    segments = len(walk.scene.character.muscles) * 64
    assert now["bipeds"] == now["counts"]["paths"] == 64
    assert now["counts"]["lines"] >= segments
    assert (now["counts"]["glass"] + now["counts"]["body"]) % 64 == 0
    shot = Image.open(io.BytesIO(page.locator("#scene").screenshot())).convert("RGB")
    page.close()
    colors = np.asarray(shot).reshape(-1, 3).astype(int)
    assert np.sum((colors[:, 2] > colors[:, 0] + 60) & (colors[:, 1] < 60)) > 50  # relaxed muscles, dark blue


def test_page_names_no_other_file_and_is_small(walk):
    text = replay_html(walk.recording, load("walk56"), autoplay=False)
    assert not re.search(r"""(?:src|href)\s*=|@import|url\(|https?://(?!www\.w3\.org)|import\(""", text)
    assert len(text) < 200_000
    assert replay_html([walk.recording] * 2, walk.scene, ["a", "b"]).count('"label":') == 2


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
