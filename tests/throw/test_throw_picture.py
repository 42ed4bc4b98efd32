"""Figures of throws: whatever a ball does, its flight and its target are within the panel."""

from io import BytesIO
from pathlib import Path

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.plots.style import matplotlib
from warpmuscle.throw import plot
from warpmuscle.throw.fit import Fitted, Stage
from warpmuscle.throw.follow import Replay
from warpmuscle.throw.goals import Goal, fly
from warpmuscle.throw.job import Job, JobOptions
from warpmuscle.throw.motion_plot import Course, draw_motion, draw_motions
from warpmuscle.throw.synthesis import Throw


@pytest.fixture(scope="module")
def job() -> Job:
    return Job(load("throw_ball"), [], JobOptions())


def thrown(job: Job, target: float, speed: float, angle: float) -> Throw:
    """A ball thrown from 2 m of height, at an angle, deg."""
    individual, motions = job.follower.extracted[0], job.motions
    turn = np.radians(angle)
    velocity = speed * np.array([[np.cos(turn), np.sin(turn)]])
    flight = fly(np.array([[0.3, 2.0]]), velocity, 9.81, 0.0)
    replay = Replay(motions.angles[0], motions.angles[1])
    return Throw(Goal(target), flight, 1.0, 0.0, 0.0, 9.81, individual, individual, replay, (0,), 0.0, np.ones(3))


@pytest.mark.parametrize(("target", "speed", "angle"), [(60.0, 1.0, -30.0), (60.0, 22.0, 40.0), (2.0, 20.0, 88.0)])
def test_far_and_steep_throws_are_within_their_panel(
    job: Job, target: float, speed: float, angle: float, monkeypatch: pytest.MonkeyPatch
):
    figures: list = []
    monkeypatch.setattr(plot, "save", lambda figure, path: figures.append(figure))
    with matplotlib().rc_context():
        plot.draw_throws("t.png", job.follower, [thrown(job, target, speed, angle)])
    figures[0].savefig(BytesIO(), format="png")  # lays it out
    axes = figures[0].subfigs[0].axes[0]
    inside, mark = axes.get_window_extent(), 4.5 * figures[0].dpi / 72.0  # half of a target's mark
    for line in axes.lines:
        if line.get_transform() == axes.transData:
            points = axes.transData.transform(line.get_xydata())
            room = mark if line.get_marker() == "x" else 0.0
            assert np.all(points - room >= [inside.x0, inside.y0])
            assert np.all(points + room <= [inside.x1, inside.y1])
    for part in (axes.get_legend(), axes.yaxis.label):
        box = part.get_window_extent()
        assert box.x0 >= 0.0
        assert box.x1 <= figures[0].bbox.x1
    assert 0.2 < inside.height / inside.width < 2.0


def test_every_motion_is_drawn_with_its_torques_muscles_signals_and_flight(job: Job, tmp_path: Path):
    """Along the recorded motion itself, which has r2 1 and a torque of muscles that the ball's weight bends."""
    follower, motions = job.follower, job.motions
    replay = Replay(motions.angles[0], motions.angles[1])
    agreement, _ = follower.agreement(follower.extracted, job.start)
    fitted = Fitted(job.start, follower.extracted, replay, [Stage("signals", agreement, 0.0, 0)])
    course = Course.of(follower, fitted)
    assert course.activation.shape == course.force.shape == (1, len(motions.time), 6)
    assert np.isfinite(course.hand).all()
    draw_motions(tmp_path / "all.png", follower, fitted)
    draw_motion(tmp_path / "one.png", follower, fitted, course, 0)
    assert all((tmp_path / name).stat().st_size > 20_000 for name in ("all.png", "one.png"))
