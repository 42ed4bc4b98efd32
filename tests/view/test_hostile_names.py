"""Names that are made to run code in a page, in every page that shows them, in a real browser."""

from collections.abc import Callable
from typing import Any

import pytest

import hostile
from warpmuscle.plots.subject import Subject
from warpmuscle.report.page import report_html
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.view.controls import Slider
from warpmuscle.view.live import Live
from warpmuscle.view.live_run import LiveRun
from warpmuscle.view.packing import encodable
from warpmuscle.view.page import Page, replay_html
from warpmuscle.view.sources import of_replays, page_of_sights
from warpmuscle.view.viewer import Viewer, replay_viewer

HIT = "document.querySelectorAll('main img[src=x], main svg, body > img, [onerror], [onload], [onmouseover]').length"


def test_the_scene_is_one_that_can_be_made():
    check_scene(hostile.scene())


def test_exported_page_shows_names_as_text(browser, tmp_path):
    sights = of_replays(hostile.result())
    page = browser.new_page(viewport={"width": 700, "height": 500})
    found = hostile.watched(page)
    page_of_sights(sights).save(tmp_path / "a.html")
    page.goto((tmp_path / "a.html").as_uri())
    page.evaluate("warpmuscle.ready")
    assert page.title() == hostile.NAMES[0]
    assert page.locator("#selected option").all_text_contents() == list(hostile.NAMES[:2])
    for group in ("angles", "torques", "activations"):
        page.evaluate(f"warpmuscle.group('{group}')")
        assert page.evaluate("warpmuscle.state().panels") >= len(hostile.NAMES) - 1  # one pair shares a panel
        page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert page.evaluate(HIT) == 0
    assert page.evaluate("({}).x === undefined && Object.keys(Object.prototype).length === 0")
    page.close()
    assert not found


@pytest.mark.parametrize("name", hostile.NAMES)
def test_every_name_can_be_the_title_of_a_page_and_stand_in_a_notebook(browser, name):
    page = browser.new_page(viewport={"width": 300, "height": 300})
    found = hostile.watched(page)
    text = replay_html(hostile.motion(), hostile.scene(), [name], title=name)
    page.set_content(Page(text)._repr_html_())
    inner = page.frames[1]
    inner.wait_for_function("window.warpmuscle && warpmuscle.ready.then(() => true)")
    assert inner.evaluate("document.querySelector('#legend b').textContent") == encodable(name)
    assert inner.evaluate(HIT) == 0
    page.close()
    assert not found


def test_report_shows_names_as_text(browser, tmp_path):
    page = browser.new_page(viewport={"width": 900, "height": 700})
    found = hostile.watched(page)
    (tmp_path / "r.html").write_text(report_html(Subject(hostile.result())), encoding="utf-8")
    page.goto((tmp_path / "r.html").as_uri())
    assert page.title() == f"{hostile.NAMES[0]}: report"
    page.wait_for_function("frames[0] && frames[0].warpmuscle && frames[0].warpmuscle.ready.then(() => true)")
    images = "Promise.all([...document.images].map((image) => image.decode().then(() => image.naturalWidth)))"
    assert min(page.evaluate(images)) > 300
    assert page.locator("pre").first.text_content() == hostile.NAMES[1]
    assert page.evaluate(HIT) == 0
    page.close()
    assert not found


def shown(browser: Any, viewer: Viewer, look: Callable[[Any], None]) -> None:
    """Look at a viewer in a browser; nothing may go wrong there."""
    viewer.start()
    page = browser.new_page(viewport={"width": 420, "height": 700})
    found = hostile.watched(page)
    page.goto(viewer.url)
    page.evaluate("warpmuscle.ready")
    look(page)
    assert page.evaluate(HIT) == 0
    page.close()
    viewer.stop()
    viewer.wait()
    assert not found


def test_replay_shows_names_as_text(browser):
    pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
    text = page_of_sights(of_replays(hostile.result()), hostile.NAMES[1]).text

    def look(page: Any) -> None:
        assert page.title() == hostile.NAMES[1]
        for name in hostile.NAMES:
            page.fill("#search", name)
        page.evaluate("warpmuscle.overlay(true); warpmuscle.find('')")
        page.evaluate("warpmuscle.play(false); warpmuscle.look('side')")
        for x in range(20, 400, 40):
            for y in range(80, 300, 40):
                page.mouse.move(x, y)

    shown(browser, replay_viewer(text, port=0), look)


def test_live_shows_names_as_text(browser):
    pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
    viewer = Live(LiveRun(hostile.scene(muscles=False)), [Slider(hostile.NAMES[0], 0.0, 1.0, 0.0)], port=0)
    assert len(viewer.parameters) == len(hostile.NAMES) + 1

    def look(page: Any) -> None:
        rows = page.locator("#side details", has=page.locator("summary", has_text="Parameters")).locator(".row")
        assert rows.count() == len(hostile.NAMES) + 1
        assert encodable(hostile.NAMES[0]) in page.locator("#side .row span").first.text_content()
        rows.first.hover()  # shows the whole name

    shown(browser, viewer, look)
