"""Objects and water in the viewer: where a motion has them, and drawn in a real browser without an error."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from small_result import walk_result, walk_scene
from warpmuscle.core.errors import Error
from warpmuscle.plots import plot
from warpmuscle.results.recording import Recording
from warpmuscle.scene import (
    BallObject,
    Body,
    BoxObject,
    CapsuleObject,
    Character,
    InitialState,
    Joint,
    Scene,
    Sphere,
    Treadmill,
    Water,
)
from warpmuscle.scene.objects.motion import QUANTITIES, object_quantities
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.view.content import doll_content, track_arrays
from warpmuscle.view.objects import object_pieces
from warpmuscle.view.page import plane_content, replay_html
from warpmuscle.view.pieces import Block, Limb
from warpmuscle.view.track import track_of

OBJECTS = {
    "ball": BallObject(radius=0.2),
    "rail": BoxObject(size=(0.1, 0.2, 4.0), position=(1.0, 0.9, 2.0), fixed=True),
    "log": CapsuleObject(position=(-1.0, 0.05, 0.0)),
}


def among(**changes) -> Scene:
    return msgspec.structs.replace(substitute(walk_scene(), start_values(walk_scene())), objects=OBJECTS, **changes)


def with_ball() -> Recording:
    """A motion whose ball rises, and whose other objects were not recorded."""
    motion = walk_result().replays[0].window(1.0, 1.5)
    moved = np.tile(np.float32([0.5, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, *[0.0] * 6]), (motion.frames, 1))
    moved[:, 1] = np.arange(motion.frames)
    units = tuple(unit for _, unit in QUANTITIES)
    return replace(motion, recorded=moved, recorded_names=object_quantities("ball"), recorded_units=units)


def test_objects_hang_on_nothing_behind_the_bodies_where_they_were():
    scene, motion = among(), with_ball()
    track = track_of(motion, scene)
    bodies = len(scene.character.bodies)
    content = doll_content(track.doll, scene, [])
    assert content["parent"][bodies:] == [-1, -1, -1]
    assert content["names"][bodies:] == ["ball", "rail", "log"]
    assert content["sliding"] == [bodies, bodies + 1, bodies + 2]
    arrays = track_arrays(track)
    assert arrays["orientation"][0].shape == (motion.frames, bodies + 3, 4)
    slid = arrays["slid"][0]
    np.testing.assert_allclose(slid[:, 0, 1], np.arange(motion.frames))
    np.testing.assert_allclose(slid[:, 1], np.tile([1.0, 0.9, 2.0], (motion.frames, 1)))


def test_pieces_are_as_large_as_the_objects():
    ball, rail, log = object_pieces(among())
    assert isinstance(ball, Limb)
    assert ball.radii == (0.2, 0.2)
    assert isinstance(rail, Block)
    assert rail.radii.tolist() == [0.05, 0.1, 2.0]
    assert isinstance(log, Limb)
    assert log.end[1] == 0.1


def test_on_a_treadmill_all_is_shown_as_the_belts_see_it():
    motion, still = with_ball(), walk_scene().ground
    belt = msgspec.structs.replace(still, treadmill=Treadmill(speed=2.0))
    track = track_of(motion, among(ground=belt))
    gone = 2.0 * motion.time
    np.testing.assert_allclose(track.recording.com[:, 2] - motion.com[:, 2], gone, atol=1e-5)
    np.testing.assert_allclose(track.objects[0].position[:, 2], 1.0 + gone, atol=1e-5)


def test_a_page_knows_how_high_water_stands():
    assert plane_content(among(water=Water(level=0.7)))["water"] == 0.7
    assert plane_content(among())["water"] is None


def test_objects_and_water_are_drawn_without_an_error(browser, tmp_path):
    path = tmp_path / "page.html"
    path.write_text(replay_html(with_ball(), among(water=Water(level=0.7))))
    context = browser.new_context(viewport={"width": 640, "height": 480}, offline=True)
    opened, problems = context.new_page(), []
    opened.on("pageerror", lambda error: problems.append(str(error)))
    opened.on("console", lambda message: problems.append(message.text) if message.type == "error" else None)
    opened.goto(path.as_uri())
    opened.evaluate("warpmuscle.ready")
    opened.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert opened.evaluate("warpmuscle.state().pictures") > 0
    context.close()
    assert problems == []


@pytest.mark.parametrize("missing", [True, False])
def test_a_recording_without_an_object_shows_it_at_its_start(missing: bool):
    motion = walk_result().replays[0].window(1.0, 1.2) if missing else with_ball()
    track = track_of(motion, among())
    assert (track.objects[0].position[-1, 1] == 0.0) == missing


def test_what_is_recorded_of_an_object_is_drawn_by_its_name():
    figure = plot(with_ball(), "objects.ball.position_y", scene=among())
    (line,) = figure.axes[0].get_lines()
    np.testing.assert_allclose(line.get_ydata(), np.arange(with_ball().frames))
    assert "m" in figure.axes[0].get_ylabel()
    with pytest.raises(Error, match="did you mean"):
        plot(with_ball(), "objects.bal.position_y", scene=among())


@pytest.mark.parametrize(
    ("height", "shapes", "seen"), [(0.5, [], True), (-0.5, [], False), (-0.5, [Sphere((0.0, 0.0, 0.0), 0.1)], True)]
)
def test_the_plane_does_not_cover_what_hangs_through_it_and_touches_nothing(height, shapes, seen):
    bodies = {"base": Body(1.0, (0.1, 0.1, 0.1)), "arm": Body(1.0, (0.01, 0.01, 0.01), shapes)}
    joint = Joint("hinge", "base", "arm", (0.0, 0.0, 0.0), (0.0, 0.1, 0.0), [(1.0, 0.0, 0.0)])
    character = Character("base", bodies, {"shoulder": joint})
    scene = Scene("arm", character, initial_state=InitialState((0.0, height, 0.0)))
    assert plane_content(scene)["visible"] is seen
