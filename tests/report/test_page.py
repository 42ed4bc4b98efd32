"""The report as a page: it is whole, needs nothing from elsewhere, escapes what is in it, and its numbers add up."""

import dataclasses
import re
import sys
from importlib.resources import files

import msgspec
import numpy as np
import pytest

from html_page import Page
from muscle_arm import arm
from patience import until
from small_result import arm_motion, no_parameters, search_result, walk_result, walk_scene
from warpmuscle.core.errors import Error
from warpmuscle.formats import toml
from warpmuscle.gait.quality import gait_measures
from warpmuscle.gait.table import gait_table
from warpmuscle.plots.subject import Subject
from warpmuscle.report.page import Figure, report_html, with_code
from warpmuscle.report.summary import shares
from warpmuscle.results.records import Result, SearchOptions, Staged
from warpmuscle.scene import SearchStage
from warpmuscle.scene.parameters import start_values, substitute

FALLS = "Falls: `warpmuscle optimize stumble56` makes it " + "walk" * 40


@pytest.fixture(scope="module")
def result() -> Result:
    """A search with the motion of its best."""
    scene = msgspec.structs.replace(walk_scene(), description=FALLS)
    return dataclasses.replace(search_result(), scene=toml.dumps(scene))


@pytest.fixture(scope="module")
def text(result) -> str:
    """Its page."""
    return report_html(Subject(result), [Subject(walk_result())])


@pytest.fixture(scope="module")
def page(text) -> Page:
    """What is in it."""
    return Page(text)


def test_every_part_is_there_and_closed(page):
    assert page.open == []
    assert page.ids == ["replay", "score", "search", "motion", "gait", "made"]
    assert sum(link.startswith("data:image/svg+xml;base64,") for link in page.links) == 8


def test_it_is_below_a_megabyte(text):
    assert len(text.encode()) < 1_000_000


def test_nothing_comes_from_elsewhere(page):
    assert all(link.startswith(("data:", "#")) for link in page.links)


def test_command_seed_device_and_versions_are_said(page, result):
    assert "warpmuscle optimize <walk56> & more" in page.texts
    assert {"seed", "7", "device", "cpu", *result.versions, *result.versions.values()} <= set(page.texts)


def test_the_terms_times_their_weights_stand_beside_the_cost(page, result):
    of, terms = shares(result)
    assert of == ""
    assert [(term.name, term.weight) for term in terms] == [("torque", 1.0), ("speed", 5.0)]
    np.testing.assert_allclose(sum(term.cost for term in terms), result.best.cost)
    assert {"torque", "speed", f"{terms[0].cost:.4g}", f"{result.best.cost:.6g}"} <= set(page.texts)
    assert "rest" not in page.texts


def test_what_the_terms_do_not_explain_is_called_so(result):
    odd = dataclasses.replace(result.best, cost=3.0 * result.best.cost)
    assert "rest" in Page(report_html(Subject(dataclasses.replace(result, best=odd, replays=())))).texts


def test_names_and_commands_cannot_become_markup(result):
    evil = "<script>alert(1)</script>"
    scene = toml.loads(result.scene)
    scene.name, scene.description = f"$evil {evil}", evil
    text = report_html(Subject(dataclasses.replace(result, scene=toml.dumps(scene), command=evil, device=evil)))
    assert evil not in text
    assert text.count("&lt;script&gt;alert(1)") >= 4


def test_a_simulation_alone_and_an_arm_have_the_parts_that_they_can():
    assert Page(report_html(Subject(walk_result()))).ids == ["replay", "motion", "gait", "made"]
    armed = Result(toml.dumps(arm()), "cpu", "", 0, no_parameters(), replays=(arm_motion(),))
    assert Page(report_html(Subject(armed))).ids == ["replay", "motion", "made"]
    with pytest.raises(Error, match="no legs to walk on"):
        report_html(Subject(walk_result()), [Subject(armed)])


def test_a_search_that_is_still_going_on_has_no_motion(result):
    assert Page(report_html(Subject(dataclasses.replace(result, replays=())))).ids == ["score", "search", "made"]


def test_measures_of_a_walk_stand_beside_those_of_people():
    measures = gait_measures(walk_result().replays[0], substitute(walk_scene(), start_values(walk_scene())))
    assert measures["speed"] == pytest.approx(walk_result().replays[0].com_velocity[100:, 2].mean(), rel=0.1)
    assert measures["hip, maximum"] == pytest.approx(np.degrees(0.3), abs=0.1)
    assert measures["cadence"] == pytest.approx(120.0)
    rows = {row.name: row for row in gait_table([measures, {"speed": 1.0}])}
    assert (rows["speed"].human, rows["speed"].unit, rows["speed"].values[1]) == ("1.27 to 1.46", "m/s", 1.0)
    assert rows["knee, maximum in swing"].human == "63.4 ± 5.3"
    assert rows["cadence"].values[1] is None
    assert all(row.unit and bool(row.human) == bool(row.source) for row in rows.values())


def test_stages_are_listed_and_the_cost_of_transport_stands_beside_that_of_people(result, monkeypatch):
    drawn = {"convergence": Figure("search", "data:,")}  # figures are looked at above and below
    monkeypatch.setattr("warpmuscle.report.page._figures", lambda *subject: drawn)
    scene = toml.loads(result.scene)
    scene.stages = [SearchStage("stand"), SearchStage("walk", {"cost_of_transport": 2.0})]
    names = ("torque", "cost_of_transport")
    evaluations = dataclasses.replace(result.evaluations, term_names=names, stage=np.ones(60, dtype=int))
    stages = tuple(
        Staged(stage.name, result.parameters.name, SearchOptions("cma", searches=3)) for stage in scene.stages
    )
    searched = dataclasses.replace(result.searched, stages=stages, stage=1, ended="the time is up")
    staged = dataclasses.replace(result, scene=toml.dumps(scene), evaluations=evaluations, searched=searched)
    page = Page(report_html(Subject(staged)))
    assert {"1, stand", "2, walk", "3 x cma", "the time is up", "Score of stage 2, walk"} <= set(page.texts)
    assert {"cost of transport", "3.05 to 3.51", "J/(kg m)"} <= set(page.texts)


def test_a_browser_without_a_network_shows_all_figures_and_plays_the_motion(browser, text, tmp_path):
    path = tmp_path / "report.html"
    path.write_text(text, encoding="utf-8")
    context = browser.new_context(viewport={"width": 1100, "height": 900}, offline=True)
    page = context.new_page()
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.on("request", lambda request: problems.append(request.url) if request.url.startswith("http") else None)
    page.goto(path.as_uri())
    assert page.title() == "walk56: report"
    widths = "Promise.all([...document.images].map((image) => image.decode().then(() => image.naturalWidth)))"
    assert len(page.evaluate(widths)) == 8
    assert min(page.evaluate(widths)) > 300
    page.locator("iframe").scroll_into_view_if_needed()
    frame = page.frame_locator("iframe").locator("body")
    assert frame.evaluate("warpmuscle.ready.then(() => warpmuscle.state().bipeds)") == 1
    page.frame_locator("iframe").locator("#play").click()
    until(lambda: frame.evaluate("() => warpmuscle.state().time") > 0.0)
    assert page.evaluate("document.documentElement.scrollWidth") <= 1100
    assert not problems
    context.close()


def test_without_jinja2_the_error_says_what_to_install(result, monkeypatch):
    monkeypatch.setitem(sys.modules, "jinja2", None)
    with pytest.raises(Error, match=re.escape("pip install 'warpmuscle[plot]'")):
        report_html(Subject(result))


def test_backticks_become_code_and_all_else_is_escaped():
    assert with_code("run `a <b>` & go") == "run <code>a &lt;b&gt;</code> &amp; go"
    assert with_code("one ` only <") == "one ` only &lt;"


def test_the_page_fits_a_phone_and_cuts_no_curve(browser, text, tmp_path):
    (tmp_path / "report.html").write_text(text, encoding="utf-8")
    page = browser.new_page(viewport={"width": 390, "height": 844})
    page.goto((tmp_path / "report.html").as_uri())
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    assert "`" not in page.inner_text("header")
    frame = page.frame_locator("iframe").locator("body")
    frame.evaluate("warpmuscle.ready")
    page.frames[1].wait_for_function(
        "() => { const rows = document.getElementById('strip').clientHeight / warpmuscle.state().rowHeight;"
        " return rows >= 1 && rows % 1 < 0.05 }"
    )
    page.close()


def test_text_can_be_read_on_its_ground():
    style = (files("warpmuscle.report") / "templates" / "report.css").read_text(encoding="utf-8")
    colours = dict(re.findall(r"--(\w+): #([0-9a-f]{6})", style))

    def light(name: str) -> float:  # relative luminance, WCAG 2.1
        parts = np.array([int(colours[name][k : k + 2], 16) / 255.0 for k in (0, 2, 4)])
        return float(
            np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4) @ [0.2126, 0.7152, 0.0722]
        )

    for text in ("ink", "quiet", "accent"):
        for ground in ("paper", "shade"):
            assert (light(ground) + 0.05) / (light(text) + 0.05) >= 4.5, (text, ground)
