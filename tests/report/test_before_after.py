"""Before and after a search: what was searched is walked again, the table says what was measured, the page has both."""

import base64
import json
import re
import zlib
from dataclasses import replace

import numpy as np
import pytest

from html_page import Page
from short_walks import limp, plain_walk, short_walk
from warpmuscle.core.status import Status
from warpmuscle.gait.muscle_effort import BHARGAVA_NET, BHARGAVA_STRICT
from warpmuscle.gait.quality import gait_measures
from warpmuscle.optimization.best_scene import is_to_walk
from warpmuscle.optimization.optimize import optimize
from warpmuscle.report import before_after
from warpmuscle.report.before_after import FALLING, Walked, before_and_after, lines, page, rows, watch
from warpmuscle.scene import SearchStage
from warpmuscle.scene.parameters import start_values
from warpmuscle.studies import judge
from warpmuscle.studies.walkers import SceneWalker


@pytest.fixture(autouse=True)
def short_runs(monkeypatch):
    monkeypatch.setattr(judge, "RUNS", 3)
    monkeypatch.setattr(judge, "SHORT", 4.0)
    monkeypatch.setattr(judge, "SLOPE", 0.0)  # the original walk falls on slopes
    monkeypatch.setattr(before_after, "LASTING", 4.0)


@pytest.fixture(scope="module")
def walks() -> tuple[Walked, Walked]:
    """A character that has no gains, and the original walk."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(judge, "RUNS", 3)
        patch.setattr(judge, "SHORT", 4.0)
        patch.setattr(judge, "SLOPE", 0.0)
        patch.setattr(before_after, "LASTING", 4.0)
        return watch(limp(), device="cpu"), watch(plain_walk(), device="cpu")


def test_what_falls_and_what_walks_is_told_apart(walks):
    limp_one, walk = walks
    assert (limp_one.status, limp_one.falls, walk.status, walk.falls) == (Status.FELL, 3, Status.COMPLETED, 0)
    assert limp_one.motion.time[-1] < 2.0 < walk.motion.time[-1]
    assert walk.measures == gait_measures(walk.motion, walk.scene)


def test_table_says_what_was_measured(walks):
    limp_one, walk = walks
    found = {name: cells for name, *cells in rows(*walks)}
    assert found["walks on its own"][:2] == [f"{limp_one.motion.time[-1]:.1f} s, then fell", "4 s"]
    assert found["speed, m/s"] == ["", f"{walk.measures['speed']:.2f}", "1.27 to 1.46"]
    assert not any(name.startswith("cost of transport") for name in found)  # it has no muscles
    told = lines(*walks)
    assert told[0].split() == ["before", "after", "people"]
    assert len(told) == len(found) + 2
    assert re.search(r"falls of 3 disturbed runs +3 +0", "\n".join(told))
    assert told[-1].startswith("disturbed: ")


def test_a_walk_on_muscles_has_both_energies_by_name_beside_the_searched_one(walks):
    costs = {"cost of transport": 5.04, BHARGAVA_NET: 3.6, BHARGAVA_STRICT: 4.38}
    muscled = replace(walks[1], measures=walks[1].measures | costs)
    found = {name: cells for name, *cells in rows(walks[0], muscled)}
    assert {name: cells for name, cells in found.items() if name.startswith("cost")} == {
        "cost of transport, J/(kg m)": ["", "5.0", "3.05 to 3.51"],
        "cost of transport, Bhargava net, J/(kg m)": ["", "3.6", "3.05 to 3.51"],
        "cost of transport, Bhargava strict, J/(kg m)": ["", "4.4", "3.05 to 3.51"],
    }


def test_falls_are_those_of_the_judge(walks):
    for walk in walks:
        assert walk.falls == 3 - judge.disturbed_upright(SceneWalker(walk.scene, "cpu"))


def test_page_is_whole_and_has_both_walks_and_what_made_it(walks):
    text = page(*walks, "warpmuscle optimize <x>")
    found = Page(text)
    assert found.open == []
    assert [link for link in found.links if link] == []
    assert "warpmuscle optimize <x>" in "".join(found.texts)
    packed = re.search(r"id=&quot;content&quot;&gt;([^&]*)&lt;/script", text)
    content = json.loads(zlib.decompress(base64.b64decode(packed[1])))
    assert [track["label"] for track in content["tracks"]] == ["before", "after"]
    assert [track["ended"] for track in content["tracks"]] == ["fell at 0.2 s", ""]
    assert content["tracks"][0]["until"] == pytest.approx(walks[0].motion.time[-1], abs=1e-3)


def test_a_walk_that_diverged_at_once_is_left_out_of_the_picture(walks):
    before, after = walks
    none = replace(before, motion=before.motion.window(100.0), shown=before.shown.window(100.0))
    assert "<iframe" in page(none, after)
    both = page(none, replace(after, shown=none.shown))
    assert "<iframe" not in both
    assert "<table>" in both


def test_who_fell_is_shown_until_it_lies(walks):
    before, after = walks
    assert after.shown is after.motion
    assert before.motion.time[-1] < 0.3
    assert before.shown.time[-1] == pytest.approx(before.motion.time[-1] + FALLING, abs=0.01)
    heights = before.shown.body_position[:, :, 1].max(axis=1)
    assert heights[-1] < 0.6 * heights[0]
    np.testing.assert_array_equal(before.shown.root_position[:5], before.motion.root_position[:5])


def test_a_search_is_walked_with_its_first_and_its_best_numbers():
    scene = short_walk(0.2)
    scene.objective.norms = 1.0
    scene.stages = [SearchStage("walk", failure={"leg_crossing": 0.1})]  # for the search alone
    result = optimize(scene, 4, device="cpu", search="random", population=4)
    before, after = before_and_after(result, device="cpu")
    gains = [[walk.scene.controller.pd[joint].kp for joint in ("lHip", "lKnee")] for walk in (before, after)]
    np.testing.assert_array_equal(gains, [start_values(scene), result.best.params])
    assert [walk.scene.failure for walk in (before, after)] == [scene.failure] * 2
    assert is_to_walk(result)


def test_only_searches_for_walks_of_people_are_walked_again():
    result = optimize(short_walk(0.05), 2, device="cpu", search="random", population=2)
    assert not is_to_walk(result)


HEADROOM = """() => {
    const scene = document.getElementById("scene"), stacked = scene.clientWidth < scene.clientHeight;
    const tall = scene.clientHeight / (stacked ? 2 : 1), places = warpmuscle.state().places;
    const labels = [...document.querySelectorAll("#labels span")].map((one) => one.getBoundingClientRect().bottom);
    const top = (k) => scene.getBoundingClientRect().top + (stacked ? k * tall : 0);
    return labels.map((bottom, k) => top(k) + tall * places[k][1] - bottom);
}"""  # px, from the centre of mass of each to its name


@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_both_walkers_stay_in_the_picture_whoever_has_fallen(browser, walks, tmp_path, size):
    (tmp_path / "page.html").write_text(page(*walks), encoding="utf-8")
    opened = browser.new_page(viewport={"width": size[0], "height": size[1]})
    opened.goto((tmp_path / "page.html").as_uri())
    frame = opened.frame_locator("iframe").locator("body")
    frame.evaluate("warpmuscle.ready")
    for time in (0.0, 0.9, 3.0, 3.9):
        frame.evaluate(
            "(_, time) => { warpmuscle.play(false); warpmuscle.seek(time);"
            " return new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))) }", time,
        )  # fmt: skip
        shown = frame.evaluate("() => warpmuscle.state().places")
        assert len(shown) == 2
        assert all(0.1 < x < 0.9 and 0.1 < y < 0.9 for x, y, _ in shown), (time, shown)
        labels = frame.evaluate(
            "() => [...document.querySelectorAll('#labels span')].map((one) => one.getBoundingClientRect())"
            ".map(({ left, right, top }) => [left >= 0, right <= innerWidth, top >= 0])"
        )
        assert labels == [[True] * 3] * 2
        if time == 0.0:  # both stand alike: neither name was pushed down onto the head by what lies over the picture
            above = frame.evaluate(HEADROOM)
            assert above[0] == pytest.approx(above[1], abs=2.0)
        texts = frame.evaluate("() => [...document.querySelectorAll('#labels span')].map((one) => one.textContent)")
        assert texts == ["before" if time == 0.0 else "before: fell at 0.2 s", "after"]
    together = frame.evaluate("() => { warpmuscle.show('split', false); return warpmuscle.state().shown.split }")
    assert together is False
    opened.close()
