"""Figures: files appear, figures stand apart, skeletons are where the bodies are."""

import dataclasses
import itertools
import sys

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from biped import biped
from small_result import march as marched
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import rotate
from warpmuscle.gait.measures import Gait
from warpmuscle.plots import stick_figures as plot
from warpmuscle.plots.projection import project
from warpmuscle.plots.style import empty_figure, style
from warpmuscle.results.recording import Recording
from warpmuscle.scene import Capsule, Ground, Scene, Terrain
from warpmuscle.scene.anatomy import convex_hull, leg, pieces
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.terrain.tiles import Waves

FEET = ("lFoot", "rFoot")


def march(speed: float) -> Recording:
    """The biped moved at constant speed for 2 s with four steps."""
    return marched(biped(), speed)


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_figure_is_written(ending: str, tmp_path):
    path = tmp_path / f"walk.{ending}"
    gait = Gait(0.0, 2.0, 1.2, 1.2, 4, 0.6, None, 120.0, 0.0)
    plot.stick_figures(march(1.2), Scene("biped", biped()), path, gait)
    assert path.stat().st_size > 10_000
    if ending == "png":
        assert path.read_bytes()[:4] == b"\x89PNG"


def test_recording_without_steps_is_drawn(tmp_path):
    whole = march(0.0)
    still = dataclasses.replace(whole, stance=0 * whole.stance)
    plot.stick_figures(still, Scene("biped", biped()), tmp_path / "still.png")
    assert (tmp_path / "still.png").exists()


@pytest.mark.parametrize(
    ("speed", "length", "said"),
    [(-0.001, -0.004, "on the spot, step length 0.00 m"), (-0.5, -0.3, "0.50 m/s backwards, step length 0.30 m"),
     (0.9, 0.5, "0.90 m/s forwards, step length 0.50 m")],
)  # fmt: skip
def test_the_heading_says_how_fast_and_which_way(speed: float, length: float, said: str):
    gait = Gait(0.0, 2.0, speed, abs(speed), 4, length, None, None, 0.0)
    assert plot._title("a", gait) == f"a: {said}"


@pytest.mark.parametrize("speed", [0.0, 1.2, -0.8, 30.0])
def test_figures_do_not_overlap_and_keep_their_order_along_the_way(speed: float):
    recording, drawn = march(speed), pieces(biped(), FEET)
    frames, offsets = plot._spread(recording, drawn)
    spans = []
    for frame in frames:
        z = np.concatenate([project(recording, piece, int(frame), (2, 1))[:, 0] for piece in drawn]) + offsets[frame]
        spans.append((z.min(), z.max()))
    ordered = spans if speed >= 0.0 else spans[::-1]
    assert all(one[1] < other[0] for one, other in itertools.pairwise(ordered))
    assert (speed < 30.0) == bool(np.any(offsets))


@pytest.mark.parametrize("view", [(2, 1), (0, 1)])
def test_ground_on_a_slope_is_drawn_where_each_figure_really_stands(view: tuple[int, int]):
    recording, drawn, ground = march(1.2), pieces(biped(), FEET), surface(Ground(normal=(0.1, 1.0, -0.2), height=0.3))
    for frame, offset in ((10, 0.0), (90, 3.0)):
        ends = plot._ground_below(recording, ground, drawn, frame, offset, view)
        for across, height in ends:
            place = recording.com[frame].astype(float)
            place[1], place[view[0]] = height, across - offset
            assert place @ ground.plane.normal == pytest.approx(0.3)
        reach = np.concatenate([project(recording, piece, frame, view)[:, 0] for piece in drawn]) + offset
        assert ends[0, 0] < reach.min() < reach.max() < ends[1, 0]


def test_joints_of_neighbouring_bodies_meet_in_the_drawing():
    recording = march(1.0)
    lines = {(piece.body, piece.side): piece for piece in pieces(biped(), FEET) if not piece.outline}
    thigh, shank = (project(recording, lines[name, "left"], 30, (2, 1)) for name in ("lUpperleg", "lLowerleg"))
    np.testing.assert_allclose(thigh[1], shank[0], atol=1e-12)


def test_sides_follow_from_the_reference_pose():
    sides = {piece.body: piece.side for piece in pieces(biped(), FEET)}
    assert sides["lLowerarm"] == sides["lFoot"] == "left"
    assert sides["rToes"] == sides["rUpperleg"] == "right"
    assert sides["pelvis"] == sides["head"] == "middle"


@pytest.mark.parametrize("middle", [-0.6, 0.0, 12.4])
def test_labels_of_a_narrow_front_view_stand_apart(middle: float):
    with style():
        figure = empty_figure(figsize=(7.2, 5.1))
        axes = figure.add_axes((0.8, 0.4, 0.72 / 7.2, 0.5))  # as wide as beside nine figures on stairs
        plot._draw_front(axes, march(1.2), [], 30)
        axes.set_xlim(middle - 0.37, middle + 0.37)
        FigureCanvasAgg(figure).draw()
    low, high = axes.get_xlim()
    shown = [label for label in axes.get_xticklabels() if low <= label.get_position()[0] <= high]
    boxes = sorted((box.x0, box.x1) for box in (label.get_window_extent() for label in shown))
    assert boxes
    assert all(one[1] < other[0] for one, other in itertools.pairwise(boxes))


def test_a_foot_of_spheres_is_drawn_as_deep_as_it_touches():
    character, radius = biped(), 0.08
    character.bodies["lFoot"].shapes = [Capsule(start=(-0.02, 0.0, -0.06), end=(0.02, 0.0, -0.06), radius=radius)]
    recording = march(1.0)
    (foot,) = (piece for piece in pieces(character, FEET) if piece.body == "lFoot")
    index, frame = recording.body_names.index("lFoot"), 30
    place, turn = recording.body_position[frame, index], recording.body_orientation[frame, index]
    ends = place + rotate(turn, np.array([[-0.02, 0.0, -0.06], [0.02, 0.0, -0.06]]))
    joints = [character.joints["lAnkle"].position_in_child, character.joints["lToeJoint"].position_in_parent]
    bones = place + rotate(turn, np.array(joints, dtype=float))
    drawn = project(recording, foot, frame, (2, 1))
    lowest = min(float(ends[:, 1].min()) - radius, float(bones[:, 1].min()))
    assert drawn[:, 1].min() == pytest.approx(lowest, abs=1e-6)
    reach = max(float(ends[:, 2].max()) + radius, float(bones[:, 2].max()))
    assert drawn[:, 0].max() == pytest.approx(reach, abs=1e-6)


def test_leg_runs_from_the_root_to_the_foot():
    assert leg(biped(), "rFoot") == ["rHip", "rKnee", "rAnkle"]
    assert leg(biped(), "pelvis") == []


def test_convex_hull_keeps_the_corners_and_drops_the_inside():
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5], [0.5, 0.0]])
    assert convex_hull(square).tolist() == [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]


def test_failures_are_one_clear_error(tmp_path, monkeypatch):
    recording, scene = march(1.0), Scene("biped", biped())
    with pytest.raises(Error, match="two frames"):
        plot.stick_figures(recording.window(2.0), scene, tmp_path / "a.png")
    with pytest.raises(Error, match=r"nowhere.a\.png: cannot be written: its folder does not exist"):
        plot.stick_figures(recording, scene, tmp_path / "nowhere" / "a.png")
    with pytest.raises(Error, match=r"a\.xyz: a figure is written as \.png, \.svg, \.pdf"):
        plot.stick_figures(recording, scene, tmp_path / "a.xyz")
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(Error, match=r"pip install 'warpmuscle\[plot\]'"):
        plot.stick_figures(recording, scene, tmp_path / "a.png")


def test_ground_that_is_not_flat_is_drawn_as_it_is_below_a_figure():
    recording, drawn = march(1.2), pieces(biped(), FEET)
    ground = surface(Ground(terrain=Terrain([Waves(0.1, length=0.5)])))
    line = plot._ground_below(recording, ground, drawn, 10, 2.0, (2, 1))
    assert len(line) > 20
    np.testing.assert_allclose(line[:, 1], ground.height_at(recording.com[10, 0], line[:, 0] - 2.0), atol=1e-12)
