"""All numbers of a running scene and the editor of its curves, in a real browser, by pointer, keys and on a phone."""

import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp

from live_viewer import MARKED, TOLD, caught_up, running_viewer, until
from patience import for_a_moment
from warpmuscle.formats import load
from warpmuscle.kernels.algebra.spline import curve_value
from warpmuscle.kernels.structs import Knot
from warpmuscle.view.live import Live

pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
HIP = "controller.states.0.trajectories.SWING_Hip.components.1"


@pytest.fixture
def live() -> Iterator[Live]:
    with running_viewer() as viewer:
        yield viewer


def opened(browser: Any, live: Live, width: int, height: int) -> Any:
    page = browser.new_page(viewport={"width": width, "height": height})
    page.problems = []
    page.on("pageerror", lambda error: page.problems.append(str(error)))
    page.on("console", lambda message: page.problems.append(message.text) if message.type == "error" else None)
    page.add_init_script(MARKED)
    page.goto(live.url)
    page.evaluate("warpmuscle.ready")
    page.locator("#numbers > summary").click()
    return page


def found(page: Any, words: str) -> Any:
    page.fill("#numbers > input[type=search]", words)
    return page.locator("#numbers .row:visible:not(.tools)")


def comes(live: Live, page: Any, condition: Callable[[], object]) -> None:
    """Wait for what an edit does, and until the page has heard of it: else it may change beneath the next one."""
    until(condition)
    caught_up(live, page)


def hip_of(live: Live) -> tuple[list[float], list[float]]:
    """Phases and angles of the swing hip that the device has."""
    with live.lock:
        component = live.run.numeric.controller.states[0].trajectories["SWING_Hip"].components[1]
        knots = live.run.rollout.model.simbicon.knots.numpy()[0]
        place = next(k for k, knot in enumerate(knots) if abs(knot["phase"] - component.phase[0]) < 1e-6
                     and abs(knot["value"] - component.angle[0]) < 1e-6)  # fmt: skip
        curve = knots[place : place + len(component.phase)]
        np.testing.assert_allclose(curve["value"], component.angle, atol=1e-6)
        return curve["phase"].tolist(), curve["value"].tolist()


def test_a_number_is_found_moved_taken_back_and_saved(browser, live, tmp_path):
    page = opened(browser, live, 900, 700)
    rows = found(page, "gains lElbow KP")
    assert rows.count() == 1
    assert "N m/rad" in rows.inner_text()
    body = live.run.rollout.names.body_of_joint("lElbow")

    def gain() -> float:
        with live.lock:
            return float(live.run.rollout.model.simbicon.gains.numpy()["kp"][0, body])

    rows.locator("input[type=number]").fill("8")
    page.keyboard.press("Enter")
    comes(live, page, lambda: gain() == 8.0)
    rows.locator("input[type=range]").focus()
    page.keyboard.press("ArrowRight")
    comes(live, page, lambda: gain() > 8.0)
    until(lambda: "1 changed" in page.locator("#numbers > summary").inner_text())
    with page.expect_download() as download:
        page.get_by_role("button", name="save as a scene").click()
    assert download.value.suggested_filename == "fwalk_edited.toml"
    download.value.save_as(tmp_path / "own.toml")
    assert load(Path(tmp_path / "own.toml")).controller.pd["lElbow"].kp.value == pytest.approx(gain())
    page.get_by_role("button", name="copy as --set").click()
    page.locator("#copy[open]").wait_for()
    copied = page.locator("#copy textarea").input_value()
    assert copied.startswith("warpmuscle simulate fwalk")
    assert f"--set controller.pd.lElbow.kp={gain():.6g}"[:40] in copied
    page.locator("#copy").get_by_role("button", name="close").click()
    rows.locator("button.back").click()
    comes(live, page, lambda: gain() == 5.0)
    until(lambda: rows.locator("input[type=number]").input_value() == "5")  # once the slider has settled
    page.get_by_role("button", name="undo", exact=True).first.click()
    comes(live, page, lambda: gain() > 8.0)
    page.evaluate(TOLD)
    rows.locator("input[type=number]").fill("-3")
    page.keyboard.press("Enter")
    until(lambda: "refused" in str(page.evaluate("told")))
    assert gain() > 8.0
    assert found(page, "no such words").count() == 0
    assert page.locator("#numbers > p").inner_text() == "nothing is called so"
    assert not page.problems
    page.close()


def test_a_curve_is_bent_by_pointer_and_keys_and_gets_points(browser, live):
    page = opened(browser, live, 1000, 760)
    begun = hip_of(live)
    found(page, "swing hip curve").first.wait_for(state="detached")  # "curve" is no word of its key
    found(page, "swing hip angle").first.locator("button").click()
    points = page.locator("#editor .point")
    assert points.count() == 6
    box = points.nth(2).bounding_box()
    page.mouse.move(box["x"] + 15, box["y"] + 15)
    page.mouse.down()
    page.mouse.move(box["x"] + 15, box["y"] - 15, steps=4)
    page.mouse.up()
    comes(live, page, lambda: hip_of(live)[1][2] > begun[1][2] + 0.02)
    assert hip_of(live)[0] == pytest.approx(begun[0], abs=2e-3)  # straight up
    points.nth(1).focus()
    page.keyboard.press("Shift+ArrowDown")
    comes(live, page, lambda: hip_of(live)[1][1] < begun[1][1] - 0.02)
    page.keyboard.press("ArrowRight")
    comes(live, page, lambda: hip_of(live)[0][1] > begun[0][1] + 0.005)
    page.keyboard.press("Insert")
    comes(live, page, lambda: len(hip_of(live)[0]) == points.count() == 7)
    page.keyboard.press("Delete")
    comes(live, page, lambda: len(hip_of(live)[0]) == points.count() == 6)
    place = page.locator("#editor canvas").bounding_box()
    page.locator("#editor canvas").dblclick(position={"x": 0.4 * place["width"], "y": 0.3 * place["height"]})
    comes(live, page, lambda: len(hip_of(live)[0]) == points.count() == 7)
    page.keyboard.press("Control+z")
    comes(live, page, lambda: len(hip_of(live)[0]) == points.count() == 6)
    points.nth(0).focus()
    for _ in range(40):  # no farther than its neighbour
        page.keyboard.press("Shift+ArrowRight")
    comes(live, page, lambda: hip_of(live)[0][0] > hip_of(live)[0][1] - 0.005)
    assert hip_of(live)[0] == sorted(hip_of(live)[0])
    page.get_by_label("value of the point, number").fill("0.25")
    page.keyboard.press("Enter")
    comes(live, page, lambda: hip_of(live)[1][0] == 0.25)
    slider = page.get_by_label("value of the point", exact=True)
    assert float(slider.get_attribute("max")) > 0.25  # the page has made it anew about the number
    reach = slider.get_attribute("max")
    box = slider.bounding_box()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + 8)
    page.mouse.down()
    for part in (0.8, 0.9, 0.97, 0.99):
        page.mouse.move(box["x"] + part * box["width"], box["y"] + 8)
        for_a_moment()
        assert slider.get_attribute("max") == reach  # it does not run away under the hand
    page.mouse.up()
    until(lambda: slider.get_attribute("max") != reach)
    page.locator("#editor").get_by_role("button", name="scene's curve").click()
    until(lambda: hip_of(live) == begun)
    page.keyboard.press("Escape")
    assert page.locator("#editor").is_hidden()
    assert page.locator("#plots").is_visible()
    assert not page.problems
    page.close()


def test_the_points_of_a_curve_are_copied_as_toml(browser, live):
    page = opened(browser, live, 900, 700)
    found(page, "swing hip angle").first.locator("button").click()
    page.get_by_role("button", name="copy as TOML").click()
    page.locator("#copy[open]").wait_for()
    key, *_ = page.locator("#copy textarea").input_value().splitlines()
    own = next(one for one in live.editor.for_page()["curves"] if f"# {one['key']}" == key)
    said = tomllib.loads(page.locator("#copy textarea").input_value())
    assert list(said.values()) == [pytest.approx(own["at"]), pytest.approx(own["along"])]
    assert not page.problems
    page.close()


def test_on_a_phone_the_body_and_the_curve_are_both_seen(browser, live):
    page = opened(browser, live, 390, 760)
    found(page, "swing hip angle").first.locator("button").click()
    for part in ("#scene", "#editor canvas", "#editor .fields"):
        box = page.locator(part).bounding_box()
        assert box["height"] > (50 if part.endswith("fields") else 100)
        assert box["x"] >= 0
        assert box["x"] + box["width"] <= 390
        assert box["y"] + box["height"] <= 760
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.get_by_role("button", name="close", exact=True).click()
    assert not page.problems
    page.close()


@wp.kernel
def evaluated(knots: wp.array2d(dtype=Knot), x: wp.array(dtype=float), y: wp.array(dtype=float)):
    i = wp.tid()
    y[i] = curve_value(knots, 0, 0, knots.shape[1], x[i])


def test_the_curve_that_is_drawn_is_the_one_that_is_followed(browser, live):
    at, along = [0.02, 0.23, 0.52, 0.9], [-0.1, -0.5, 0.2, 0.1]
    x = np.linspace(-0.1, 1.1, 49)
    page = opened(browser, live, 400, 400)
    drawn = page.evaluate(
        "([at, along, x]) => x.map((one) => curveValue(at, along, one, false))", [at, along, x.tolist()]
    )
    knots = np.zeros((1, 4), dtype=Knot.numpy_dtype())
    knots["phase"], knots["value"] = at, along
    device, followed = "cpu", wp.zeros(49, dtype=float, device="cpu")
    given = [wp.array(knots, dtype=Knot, device=device), wp.array(x.astype(np.float32), dtype=float, device=device)]
    wp.launch(evaluated, 49, [*given, followed], device=device)
    np.testing.assert_allclose(drawn, followed.numpy(), atol=1e-5)
    straight = page.evaluate(
        "([at, along, x]) => x.map((one) => curveValue(at, along, one, true))", [at, along, x.tolist()]
    )
    np.testing.assert_allclose(straight, np.interp(x, at, along), atol=1e-12)
    page.close()
