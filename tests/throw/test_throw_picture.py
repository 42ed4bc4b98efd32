"""Figures of throws: whatever a ball does, its flight and its target are within the panel."""

from io import BytesIO

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.plots.style import matplotlib
from warpmuscle.throw import plot
from warpmuscle.throw.follow import Replay
from warpmuscle.throw.goals import Goal, fly
from warpmuscle.throw.job import Job, Options
from warpmuscle.throw.synthesis import Throw


@pytest.fixture(scope="module")
def job() -> Job:
    return Job(load("throw_ball"), [], Options())


def thrown(job: Job, target: float, speed: float, angle: float) -> Throw:
    """A ball thrown from 2 m of height, at an angle, deg."""
    own, motions = job.follower.extracted[0], job.motions
    turn = np.radians(angle)
    velocity = speed * np.array([[np.cos(turn), np.sin(turn)]])
    flight = fly(np.array([[0.3, 2.0]]), velocity, 9.81, 0.0)
    replay = Replay(motions.angles[0], motions.angles[1])
    return Throw(Goal(target), flight, 1.0, 0.0, 0.0, 9.81, own, own, replay, (0,), 0.0, np.ones(3))


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
