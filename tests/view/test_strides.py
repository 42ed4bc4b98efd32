"""Curves over one stride are means of what was recorded between contacts, and can be kept as numbers and drawings."""

import csv
import io
import xml.etree.ElementTree as ElementTree
from typing import Any

import msgspec
import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.view.content import cycles_of
from warpmuscle.view.curves import panels_of
from warpmuscle.view.page import replay_html
from warpmuscle.view.sources import Sight, of_scene
from warpmuscle.view.track import track_of


@pytest.fixture(scope="module")
def walk() -> Sight:
    return of_scene(msgspec.structs.replace(load("fwalk"), duration=4.0), "cpu")[0]


@pytest.fixture(scope="module")
def page(browser, walk, tmp_path_factory) -> Any:
    path = tmp_path_factory.mktemp("strides") / "walk.html"
    path.write_text(replay_html(walk.recording, walk.scene), encoding="utf-8")
    page = browser.new_page(viewport={"width": 900, "height": 700})
    page.goto(f"{path.as_uri()}?time=1")
    page.evaluate("warpmuscle.ready")
    yield page
    page.close()


def saved(page: Any, kind: str) -> str:
    with page.expect_download() as waiting:
        page.select_option("#save", kind)
    return waiting.value.path().read_text(encoding="utf-8")


def test_means_and_spreads_are_those_of_the_recording(page, walk):
    assert page.is_checked("#stride input")
    head, *rows = csv.reader(io.StringIO(saved(page, "CSV")))
    numbers = np.array(rows, dtype=float)
    assert numbers[:, 0] == pytest.approx(np.linspace(0.0, 100.0, 51))
    track = track_of(walk.recording, walk.scene)
    motion, cycles = track.recording, cycles_of(track.recording, walk.scene)
    panel = next(one for one in panels_of(motion, walk.scene) if (one.group, one.title) == ("angles", "knee flexion"))
    for line in panel.lines:
        strides = np.array([np.interp(np.linspace(a, b, 51), motion.time, line.values) for a, b in cycles[line.side]])
        column = head.index(f"angles knee flexion {line.side} (°), mean")
        assert len(strides) > 1
        assert numbers[:, column] == pytest.approx(strides.mean(axis=0), abs=0.05)
        assert numbers[:, column + 1] == pytest.approx(strides.std(axis=0), abs=0.05)


def test_over_time_the_numbers_are_those_of_each_frame(page, walk):
    page.uncheck("#stride input")
    head, *rows = csv.reader(io.StringIO(saved(page, "CSV")))
    page.check("#stride input")
    track = track_of(walk.recording, walk.scene).recording
    assert head[0] == "time (s)"
    assert np.array(rows, dtype=float)[:, 0] == pytest.approx(track.time, abs=1e-3)


def test_a_drawing_is_svg_with_all_titles_and_a_picture_is_png(page):
    drawing = ElementTree.fromstring(saved(page, "SVG"))
    words = [one.text for one in drawing.iter("{http://www.w3.org/2000/svg}text")]
    assert {"hip flexion (°)", "knee flexion (°)", "ankle dorsiflexion (°)"} <= set(words)
    with page.expect_download() as waiting:
        page.select_option("#save", "PNG")
    assert waiting.value.path().read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_a_click_on_a_curve_goes_to_that_part_of_a_stride(page, walk):
    page.evaluate("warpmuscle.seek(1.5)")
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    box = page.locator("#curves").bounding_box()
    page.mouse.click(box["x"] + 38 + 0.5 * (box["width"] / 4 - 46), box["y"] + 50)  # the middle of the first of four
    (stride,) = [(a, b) for a, b in cycles_of(track_of(walk.recording, walk.scene).recording, walk.scene)["left"]
                 if a <= 1.5 < b]  # fmt: skip
    assert page.evaluate("warpmuscle.state().time") == pytest.approx(np.mean(stride), abs=0.02)
    page.keyboard.press("o")
    assert not page.is_checked("#stride input")
    page.keyboard.press("o")
