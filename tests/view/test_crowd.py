"""Many motions are coloured by what is known of each, fit a small page, and those that fail fall to the ground."""

from typing import Any

import msgspec
import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.results.result import read
from warpmuscle.scene import Failure
from warpmuscle.simulation.rollout import Rollout
from warpmuscle.view.crowd import Facts, facts_content, shades_of
from warpmuscle.view.packing import Packer, Pool
from warpmuscle.view.sources import Sight, fall_of, of_candidates, of_scene, page_of_sights, tracks_of


def test_motions_rank_by_cost_and_those_without_one_do_not():
    found = facts_content([Facts(3.0), Facts(), Facts(1.0, "fell at 0.5 s", 0.5), Facts(float("nan"))])
    assert [one.get("rank") for one in found] == [2, None, 1, None]
    assert [one.get("cost") for one in found] == [3.0, None, 1.0, None]
    assert found[2]["until"] == 0.5


@pytest.mark.parametrize(("facts", "muscles", "known", "first"), [
    ([Facts(1.0), Facts(2.0)] * 4, True, ["activation", "cost", "rank"], "cost"),
    ([Facts(1.0), Facts(2.0), Facts(21.0)] * 2, True, ["activation", "cost", "rank"], "rank"),
    ([Facts(1.0), Facts(2.0), Facts(21.0, "fell")] * 2, True, ["activation", "cost", "rank", "condition"], "cost"),
    ([Facts(0.0), Facts(2.0), Facts(21.0)] * 2, True, ["activation", "cost", "rank"], "cost"),
    ([Facts(1.0), Facts(2.0, "fell")], True, ["activation", "cost", "rank", "condition"], "activation"),
    ([Facts(), Facts(None, "fell")] * 4, False, ["condition"], "condition"),
    ([Facts()] * 9, True, ["activation"], "activation"),
    ([Facts()], False, [], ""),
])  # fmt: skip
def test_what_bodies_are_coloured_by_is_what_is_known(facts, muscles, known, first):
    assert shades_of(facts, muscles, 4) == {"known": known, "first": first}


def test_a_pool_packs_arrays_of_a_name_and_width_as_one_and_says_where_each_begins():
    pool, packer = Pool(), Packer()
    rng = np.random.default_rng(0)
    shapes = [(5, 3), (7, 3), (4, 2), (6, 3)]
    arrays = [rng.normal(size=shape) for shape in shapes]
    places = [pool.add_all({"a": (array, 16), "time": (np.arange(float(len(array))), 8)}) for array in arrays]
    found = pool.pack(packer, places)
    assert [one["a"][1] for one in found] == [0, 5, 0, 12]
    assert [one["time"][1] for one in found] == [0, 5, 12, 16]
    numbers = [one["a"][0] for one in found]
    assert numbers[0] == numbers[1] == numbers[3] != numbers[2]
    assert packer.table()[numbers[0]]["shape"] == [18, 3]


@pytest.fixture(scope="module")
def page(browser, tmp_path_factory) -> Any:
    """Twenty parts of a walk of different lengths, one of which is said to have fallen."""
    (walk,) = of_scene(msgspec.structs.replace(load("fwalk"), duration=1.6), "cpu")
    sights = [
        Sight(f"{k}", walk.recording.window(0.04 * k, 0.8 + 0.04 * k - 0.01 * k), walk.scene,
              Facts(float(k), "fell at 0.5 s" if k == 3 else ""))
        for k in range(20)
    ]  # fmt: skip
    path = tmp_path_factory.mktemp("crowd") / "crowd.html"
    path.write_text(page_of_sights(sights).text, encoding="utf-8")
    opened = browser.new_page(viewport={"width": 900, "height": 700})
    problems: list[str] = []
    opened.on("pageerror", lambda error: problems.append(str(error)))
    opened.goto(f"{path.as_uri()}?time=0.2")
    opened.evaluate("warpmuscle.ready")
    yield opened, sights
    opened.close()
    assert not problems


def test_each_of_a_crowd_is_where_it_was_recorded(page):
    opened, sights = page
    tracks = tracks_of(sights)
    for k in (0, 7, 19):
        opened.evaluate(f"warpmuscle.choose({k}); warpmuscle.seek(0)")
        own = np.array(opened.evaluate("warpmuscle.state().com"))
        opened.evaluate("warpmuscle.choose(0)")
        first = np.array(opened.evaluate("warpmuscle.state().com"))
        moved = tracks[k].recording.root_position[0] - tracks[0].recording.root_position[0]
        lane = np.array([-1.3 * (k % 8), 0.0, -2.0 * (k // 8)])
        assert own - first == pytest.approx(moved + lane, abs=0.01)


def test_colours_are_chosen_and_explained(page):
    opened, _ = page
    assert opened.evaluate("warpmuscle.state().shade") == "cost"
    assert opened.inner_text("#scale").split() == ["cost", "0", "17", "or", "more", "1", "failed"]
    opened.select_option("#shade", "condition")
    assert opened.inner_text("#scale").split("\n") == ["condition", "19 went on", "1 failed"]
    opened.select_option("#shade", "cost")


def test_candidates_that_fail_fall_to_the_ground_and_say_when(tmp_path):
    from warpmuscle.optimization.optimize import optimize

    scene = msgspec.structs.replace(load("fwalk"), duration=3.0)
    optimize(scene, 8, search="random", output=tmp_path / "found.h5")
    result = read(tmp_path / "found.h5")
    sights = of_candidates(result, 8, "cpu", "found.h5")
    assert [sight.facts.cost for sight in sights] == sorted(result.evaluations.cost)
    failed = [sight for sight in sights if sight.facts.ended]
    assert failed
    assert len(failed) < 8
    for sight in failed:
        plain = Rollout(sight.scene, 1, "cpu")
        plain.run()
        assert sight.facts.until == pytest.approx(float(plain.end_time()[0]))
        assert sight.recording.time[-1] >= sight.facts.until - 0.03
    early = min(failed, key=lambda sight: sight.facts.until)  # it has the time to fall
    assert early.recording.time[-1] > early.facts.until + 0.3
    assert early.recording.com[-1, 1] < 0.5 * early.recording.com[0, 1]


def test_who_fails_goes_on_to_the_ground_and_says_when():
    scene = msgspec.structs.replace(load("fwalk"), duration=0.8, failure=Failure(com_height=0.999))
    (sight,) = of_scene(scene, "cpu")
    assert sight.facts.ended == f"fell at {sight.facts.until:.1f} s"
    assert 0.0 < sight.facts.until < 0.7
    assert sight.recording.time[-1] == pytest.approx(0.8, abs=0.03)


def test_a_recording_that_stopped_low_fell_and_one_that_was_only_cut_did_not(walk):
    short, scene = walk.recording, msgspec.structs.replace(walk.scene, duration=2.0)
    assert fall_of(short, scene) == Facts()
    com = short.com.copy()
    com[-1, 1] *= 0.85
    low = short.changed(com=com)
    assert fall_of(low, scene) == Facts(None, "fell at 0.3 s", float(short.time[-1]))
    assert fall_of(low, msgspec.structs.replace(scene, duration=float(short.time[-1]))) == Facts()
    assert fall_of(low, msgspec.structs.replace(scene, failure=Failure(com_height=0.0))) == Facts()


@pytest.fixture(scope="module")
def walk() -> Sight:
    return of_scene(msgspec.structs.replace(load("walk56"), duration=0.3), "cpu")[0]


def crowd_of(walk: Sight, count: int, browser: Any, folder: Any) -> Any:
    """The open page of so many equal walks of different costs."""
    sights = [Sight(f"candidate {k}", walk.recording, walk.scene, Facts(float(k))) for k in range(count)]
    (folder / "crowd.html").write_text(page_of_sights(sights).text, encoding="utf-8")
    opened = browser.new_page(viewport={"width": 1280, "height": 900})
    opened.goto(f"{(folder / 'crowd.html').as_uri()}?time=0.1&shot=1")
    opened.evaluate("warpmuscle.ready")
    return opened


DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(warpmuscle.state()))))"


def test_near_ones_of_a_crowd_show_their_muscles_and_far_ones_do_not(browser, tmp_path, walk):
    opened = crowd_of(walk, 20, browser, tmp_path)
    muscles = len(walk.scene.character.muscles)
    near = opened.evaluate(DRAWN)["counts"]
    assert near["muscles"] >= 8 * muscles  # a stretch each, at least
    assert near["muscles"] % 8 == near["near_flesh"] % 8 == 0
    assert near["near_flesh"] * 12 == near["flesh"] * 8
    assert "activation, of the nearest" in opened.inner_text("#scale")
    opened.evaluate("warpmuscle.zoom(30)")
    far = opened.evaluate(DRAWN)["counts"]
    assert (far["muscles"], far["near_flesh"], far["near_bone"]) == (0, 0, 0)
    assert "activation" not in opened.inner_text("#scale")
    opened.evaluate("warpmuscle.zoom(1 / 30); warpmuscle.show('muscles', false)")
    assert opened.evaluate(DRAWN)["counts"]["muscles"] == 0
    opened.close()


def test_no_label_covers_another(browser, tmp_path, walk):
    opened = crowd_of(walk, 12, browser, tmp_path)
    opened.evaluate(DRAWN)
    boxes = opened.evaluate("""[...document.querySelectorAll('#labels span')]
        .filter((one) => !one.hidden && one.style.visibility === 'visible')
        .map((one) => one.getBoundingClientRect()).map(({ left, right, top, bottom }) => [left, right, top, bottom])""")
    assert 3 <= len(boxes) <= 12
    for k, (left, right, top, bottom) in enumerate(boxes):
        for a, b, c, d in boxes[:k]:
            assert left >= b - 1 or right <= a + 1 or top >= d - 1 or bottom <= c + 1
    assert opened.is_visible("#labels span.chosen")
    opened.close()


def test_a_page_of_two_scenes_names_both_and_is_split_where_it_is_narrow(browser, tmp_path, walk):
    other = Sight("other", walk.recording, msgspec.structs.replace(walk.scene, name="other"))
    (tmp_path / "two.html").write_text(page_of_sights([walk, other]).text, encoding="utf-8")
    for width, split in ((390, True), (1280, False)):
        opened = browser.new_page(viewport={"width": width, "height": 780})
        opened.goto((tmp_path / "two.html").as_uri())
        assert opened.evaluate("warpmuscle.ready.then(() => warpmuscle.state().shown.split)") is split
        assert opened.inner_text("#legend b") == "walk56, other"
        opened.close()
