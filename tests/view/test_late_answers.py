"""Over a slow network a page hears late what came of its words: older answers do not take back what was done since."""

from collections.abc import Iterator
from typing import Any

import pytest

from live_viewer import running_viewer, until, used
from warpmuscle.view.live import Live

pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")

# What a page is told in words waits in `late`, once it is `holding`, until it is let through.
LATE = """(() => { const Plain = WebSocket;
    Object.assign(window, { late: [], holding: false });
    window.edits = () => late.filter(({ words }) => words.edits).length;
    window.hear = (name) => {
        for (let one = {}; !one.words?.[name];) { one = late.shift(); one.act(); } };
    window.WebSocket = class extends Plain {
        set onmessage(act) { super.onmessage = (event) => {
            const go = () => act.call(this, event);
            if (holding && typeof event.data === "string") late.push({ words: JSON.parse(event.data), act: go });
            else go(); }; }
    }; })()"""


@pytest.fixture
def late(browser) -> Iterator[tuple[Live, Any]]:
    """A walk, and a page that hears of it late once it is `holding`."""
    with running_viewer() as viewer:
        page = browser.new_page(viewport={"width": 900, "height": 700})
        page.add_init_script(LATE)
        page.goto(viewer.url)
        page.evaluate("warpmuscle.ready")
        until(lambda: page.evaluate("warpmuscle.state().received") > 0)
        yield viewer, page
        page.close()


def told(page: Any, edits: int) -> None:
    """Wait until so many answers to edits are on their way."""
    until(lambda: page.evaluate("edits()") >= edits)


def test_a_curve_stays_as_it_was_bent_last(late):
    _, page = late
    page.locator("#numbers > summary").click()
    page.fill("#numbers > input[type=search]", "swing hip angle")
    page.locator("#numbers .row:visible:not(.tools) button").first.click()
    points = page.locator("#editor .point")
    page.evaluate("holding = true")
    points.nth(1).focus()
    page.keyboard.press("Shift+ArrowUp")
    told(page, 1)
    page.keyboard.press("Delete")
    assert points.count() == 5
    told(page, 2)
    page.evaluate("hear('edits')")
    assert points.count() == 5
    page.evaluate("hear('edits')")
    assert points.count() == 5
    page.keyboard.press("Control+z")
    told(page, 1)
    page.evaluate("hear('edits')")
    assert points.count() == 6


def test_a_number_stays_as_it_was_given_last(late):
    viewer, page = late
    page.locator("#numbers > summary").click()
    page.fill("#numbers > input[type=search]", "gains lElbow KP")
    number = page.locator("#numbers .row:visible:not(.tools) input[type=number]")
    page.evaluate("holding = true")
    for count, typed in enumerate(("8", "9"), start=1):
        number.fill(typed)
        page.keyboard.press("Enter")
        told(page, count)
    page.evaluate("hear('edits')")
    assert number.input_value() == "9"
    page.evaluate("hear('edits')")
    assert number.input_value() == "9"
    with viewer.lock:  # what another page does is shown
        viewer.editor.set_number("controller.pd.lElbow.kp", 7.0)
    told(page, 1)
    page.evaluate("hear('edits')")
    assert number.input_value() == "7"


def test_a_control_stays_as_it_was_set_last(late):
    viewer, page = late
    number = page.get_by_label("impulse, number")
    page.evaluate("holding = true")
    for count, typed in enumerate(("33", "44"), start=1):
        number.fill(typed)
        page.keyboard.press("Enter")
        until(lambda count=count: page.evaluate("late.filter(({ words }) => words.values).length") >= count)
    page.evaluate("hear('values')")
    assert number.input_value() == "44"
    page.evaluate("hear('values')")
    assert number.input_value() == "44"
    viewer.server.on_message(used(viewer, viewer.impulse, 55.0))
    until(lambda: page.evaluate("late.some(({ words }) => words.values)"))
    page.evaluate("hear('values')")
    assert number.input_value() == "55"


def test_what_changes_nothing_is_answered_too(late):
    """A page that waits for the answer to its last words would else not hear what others do meanwhile."""
    viewer, page = late
    page.locator("#numbers > summary").click()
    page.fill("#numbers > input[type=search]", "gains lElbow KP")
    number = page.locator("#numbers .row:visible:not(.tools) input[type=number]")
    page.evaluate("document.activeElement.blur()")  # in a box it would be of what is typed
    page.evaluate("holding = true")
    with viewer.lock:
        viewer.editor.set_number("controller.pd.lElbow.kp", 6.0)
    told(page, 1)
    page.keyboard.press("Control+Shift+z")  # there is nothing to make again
    told(page, 2)
    page.evaluate("hear('edits')")
    assert number.input_value() == "5"
    page.evaluate("hear('edits')")
    assert number.input_value() == "6"
