"""What files keep of fits and new throws, and what figures, viewer and report make of them."""

from pathlib import Path

import h5py
import numpy as np
import pytest

from described import assert_described
from small_disk import disk_of
from warpmuscle.core.errors import ResultError
from warpmuscle.formats import load
from warpmuscle.formats.toml import loads as load_text
from warpmuscle.plots import KINDS, Absent, Choices, Subject, draw
from warpmuscle.report.page import report_html
from warpmuscle.report.summary import report
from warpmuscle.results.result import read
from warpmuscle.throw.job import Job
from warpmuscle.view.sources import of_replays, tracks_of


def test_a_fit_is_kept_whole_with_the_scene_that_it_came_to(job: Job, tmp_path):
    job.write(tmp_path / "throw.h5", {"command": "test"})
    assert_described(tmp_path / "throw.h5")
    with h5py.File(tmp_path / "throw.h5") as file:
        assert file.attrs["format"] == "warpmuscle throw"
        assert file["fit/angle"].shape == file["motions/angle"].shape == (1, 151, 3)
        assert file["fit/r2"][-1].min() > 0.999
        (tmp_path / "fitted.toml").write_text(file["fit"].attrs["scene"])
    assert load(str(tmp_path / "fitted.toml")).character.muscles["m1"].f_max.value != 1142.6


def test_a_fit_is_kept_with_some_quantities_of_its_motions(job: Job, tmp_path):
    job.write(tmp_path / "throw.h5", {"command": "test"}, ["com"], single=True)
    motion = read(tmp_path / "throw.h5").replays[0]
    assert motion.com.dtype == np.float32
    assert len(motion.com) == motion.frames > 0
    assert motion.body_position.shape[0] == 0


def test_full_disk_leaves_an_older_file_of_throws(job: Job, kept, tmp_path):
    path = tmp_path / "throw.h5"
    path.write_text("older")
    with disk_of(64), pytest.raises(ResultError, match=r"throw\.h5: cannot be written: file too large"):
        job.write(path, {"command": "warpmuscle throw", "seed": 3})
    assert [(file.name, file.read_text()) for file in tmp_path.iterdir()] == [("throw.h5", "older")]


def test_the_file_holds_motions_as_other_results_do_beside_the_recorded_ones(job: Job, kept):
    result = read(kept)
    assert (result.seed, result.replay_names) == (3, ("throw", "throw at 1.5 m"))
    simulated, recorded = (
        hinge_angle(q) for q in (result.replays[0].joint_orientation, result.replays[0].joint_target)
    )
    np.testing.assert_allclose(simulated, job.fitted.replay.angle[0, :-1], atol=1e-5)
    np.testing.assert_allclose(recorded, job.motions.angles[0][0, :-1], atol=1e-6)
    thrown = hinge_angle(result.replays[1].joint_orientation)
    np.testing.assert_allclose(thrown, job.throws[0].replay.angle[0, :-1], atol=1e-5)
    assert np.abs(thrown - simulated).max() > 0.01
    best = load_text(result.scene).character.muscles["m1"].f_max.value
    assert best == pytest.approx(result.parameters.value[result.parameters.name.index("character.muscles.m1.f_max")])


def hinge_angle(quaternion: np.ndarray) -> np.ndarray:
    """Angles (F, 3) of quaternions xyzw, rad: shoulder and elbow turn about -x, the wrist about x."""
    return np.array([-2.0, -2.0, 2.0]) * np.arctan2(quaternion[..., 0], quaternion[..., 3])


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_figure_is_drawn_or_says_in_a_line_why_not(kind: str, kept):
    subject = Subject(read(kept), path=kept)
    if kind in ("angles", "feet", "ground_force", "moments", "body", "parameters"):
        with pytest.raises(Absent, match=r"no legs|holds no search") as caught:
            draw(subject, kind)
        assert "\n" not in str(caught.value)
    else:
        assert draw(subject, kind).axes


def test_angles_are_drawn_over_the_recorded_ones(kept):
    panels = draw(Subject(read(kept)), "joints").axes
    assert [len(axes.lines) for axes in panels] == [4, 3, 3]  # recorded, simulated, zero; a legend
    below, above = (line.get_ydata() for line in panels[1].lines[:2])
    np.testing.assert_allclose(below, above, atol=2.0)
    assert not np.array_equal(below, above)


@pytest.mark.parametrize(("name", "panels"), [("/fit/C", 1), ("/motions/angle", 1), ("/replay/1/muscle_force", 1)])
def test_datasets_of_recorded_motions_are_drawn_over_time(name: str, panels: int, kept):
    figure = draw(Subject(read(kept), path=kept), f"dataset:{name}")
    assert len(figure.axes) == panels
    assert figure.axes[0].get_xlabel() == "time (s)"


def test_the_viewer_shows_the_recorded_motion_as_the_desired_one(kept):
    sights = of_replays(read(kept))
    assert [sight.label for sight in sights] == ["throw", "throw at 1.5 m"]
    track = tracks_of(sights)[1]
    assert np.abs(track.desired[:, -1] - track.recording.body_orientation[:, -1]).max() > 0.01
    np.testing.assert_allclose(track.desired[:, 0], track.recording.body_orientation[:, 0])


def test_the_report_of_a_fit_says_how_it_went_and_which_motions_there_are(kept):
    lines = report(read(kept))
    assert "fit of 1 motion: r2 of shoulder, elbow, wrist" in lines
    assert lines[-2:] == ["motion 0: throw", "motion 1: throw at 1.5 m"]
    page = report_html(Subject(read(kept), Choices(replay=1), kept))
    assert "r2 of elbow" in page
    assert page.count("<iframe") == 1


def test_goals_releases_flights_and_landings_are_in_the_file(kept: Path):
    with h5py.File(kept) as file:
        one = file["throws"]
        assert one["goal/distance"][:] == pytest.approx([1.5])
        assert np.isnan(one["goal/speed"][0])
        place, velocity, duration = one["release_position"][0], one["release_velocity"][0], one["flight_time"][0]
        forward, up = place + velocity * duration - [0.0, 0.5 * 9.81 * duration**2]
        np.testing.assert_allclose(one["landing_position"][0], [forward, up], atol=1e-6)
        assert one["landing_position"][0, 0] == pytest.approx(1.5, abs=0.05)
        assert one["release_speed"][0] == pytest.approx(np.hypot(*velocity))
        assert one["release_time"].attrs["units"] == "s"
        assert one["met"][0]
