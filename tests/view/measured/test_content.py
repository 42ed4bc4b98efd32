"""Measured markers and forces are sent to the page in the frames of the motion, without gaps."""

import msgspec
import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.inverse.recordings.measured import Measured
from warpmuscle.view.measured.content import at_times, filled, measured_arrays, measured_content
from warpmuscle.view.sources import Sight, of_scene, page_of_sights


def measured(times, markers: int = 2) -> Measured:
    frames = len(times)
    position = np.arange(frames * markers * 3, dtype=float).reshape(frames, markers, 3) * 0.01
    names = tuple(f"m{k}" for k in range(markers))
    force = np.tile([0.0, 500.0, 0.0], (frames, 1, 1))
    return Measured(np.asarray(times), names, position, position + 0.01, ("lFoot",), force, np.zeros((frames, 1, 3)))


def test_frames_are_those_of_the_motion_and_others_are_left_out():
    known = measured([0.0, 0.1, 0.2, 0.3])
    found = at_times(known, np.array([0.1, 0.3]))
    np.testing.assert_allclose(found.position, known.position[[1, 3]])
    np.testing.assert_allclose(found.force, known.force[[1, 3]])
    assert at_times(known, np.array([0.1, 0.35])) is None
    assert at_times(None, np.array([0.1])) is None


def test_gaps_are_filled_from_before_and_told():
    position = np.array([[[np.nan] * 3], [[1.0, 2.0, 3.0]], [[np.nan] * 3], [[4.0, 5.0, 6.0]]])
    np.testing.assert_allclose(filled(position)[:, 0, 0], [1.0, 1.0, 1.0, 4.0])
    np.testing.assert_allclose(filled(np.full((3, 1, 3), np.nan)), 0.0)
    known = measured([0.0, 0.1, 0.2, 0.3], 1)
    gaps = Measured(known.times, known.markers, position, position, (), known.force[:, :0], known.point[:, :0])
    arrays = measured_arrays(gaps)
    np.testing.assert_array_equal(arrays["seen"][0][:, 0], [0.0, 1.0, 0.0, 1.0])
    assert sorted(arrays) == ["marker", "modelled", "seen"]
    assert sorted(measured_arrays(known)) == ["marker", "modelled", "plate", "plate_point"]
    assert measured_arrays(None) == {}


@pytest.fixture(scope="module")
def walk() -> Sight:
    return of_scene(msgspec.structs.replace(load("walk56"), duration=0.3), "cpu")[0]


def test_forces_have_the_side_of_their_foot(walk):
    assert measured_content(measured([0.0]), walk.scene) == {"markers": ["m0", "m1"], "plates": ["left"]}


def test_a_page_shows_balls_and_forces_where_they_were_measured(browser, walk, tmp_path):
    times = walk.recording.time
    sight = Sight("walk", walk.recording, walk.scene, measured=measured(times))
    (tmp_path / "a.html").write_text(page_of_sights([sight]).text)
    page = browser.new_page(viewport={"width": 500, "height": 400})
    page.goto((tmp_path / "a.html").as_uri() + "?frame=3")
    page.evaluate("warpmuscle.ready")

    def marks() -> int:
        page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
        return page.evaluate("warpmuscle.state().counts.marks")

    both = marks()
    assert page.evaluate("warpmuscle.state().shown.markers") is True
    page.evaluate("warpmuscle.show('markers', false)")
    without = marks()
    assert both - without == 2 * 3  # a ball of each, one of the model, and a line between
    page.evaluate("warpmuscle.show('forces', false)")
    assert without - marks() == 2  # the shaft and the head of one arrow
    assert "of the model" in page.inner_text("#legend")
    page.close()
