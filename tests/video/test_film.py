"""Films: frames show the whole character, repeat without a jump, and become files of the right length."""

import dataclasses
import sys

import msgspec
import numpy as np
import pytest
from PIL import Image

from muscle_arm import arm
from small_result import arm_motion, walk_result, walk_scene
from warpmuscle.core.errors import Error
from warpmuscle.scene import BallObject, BoxObject, Force, Ground, Terrain, Water
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.terrain.tiles import Stairs
from warpmuscle.video import Film, Look, films_beside, make_film, write
from warpmuscle.video.camera import camera_on
from warpmuscle.video.painter import Painter
from warpmuscle.video.side_by_side import Sheet

SMALL = {"width": 160, "height": 120}


@pytest.fixture(scope="module")
def film() -> Film:
    """A second of a walk at ten frames a second."""
    motion = walk_result().replays[0].window(1.0, 2.0)
    return make_film(motion, walk_scene(), Look(**SMALL, rate=10.0))


def test_every_point_lies_within_the_picture(film):
    for k in range(len(film.time)):
        points = np.concatenate([film.corners(k), film.muscle_points[k]])
        flat, depth = film.camera.project(points, film.followed[k])
        assert np.all(np.abs(flat) <= [160.0 / 120.0, 1.0])
        assert np.all(depth > 0.0)


def test_seen_from_the_right_forwards_is_to_the_right_and_up_is_up():
    box = np.array([[-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]])
    camera = camera_on(box, 0.0, 0.0, 1.5)
    flat, _ = camera.project(np.array([[0.0, 1.0, 1.0], [0.0, 2.0, 0.0]]), np.zeros(3))
    assert flat[0, 0] > 0.1
    assert flat[0, 1] == pytest.approx(0.0, abs=1e-12)
    assert flat[1, 1] > 0.1
    assert camera.forward == pytest.approx([1.0, 0.0, 0.0])


def test_frames_change_as_the_character_moves_and_muscles_have_their_colours(film):
    painter = Painter(film)
    first, later = painter.frame(0), painter.frame(5)
    assert first.shape == (120, 160, 3)
    assert np.mean(np.any(first != later, axis=-1)) > 0.01
    np.testing.assert_array_equal(painter.frame(0), first)


def test_a_film_of_whole_strides_ends_as_it_begins():
    film = make_film(walk_result().replays[0], walk_scene(), Look(**SMALL, strides=2))
    step = film.time[1] - film.time[0]
    assert len(film.time) == 60
    assert film.time[-1] + step == pytest.approx(film.time[0] + 2.0)
    advance = film.followed[-1] - film.followed[0] + (film.followed[1] - film.followed[0])
    assert advance[2] / (2.0 * film.tile) == pytest.approx(round(advance[2] / (2.0 * film.tile)))
    places = film.position - film.followed[:, None]
    moves = np.abs(np.diff(places, axis=0)).max()
    assert np.abs(places[-1] - places[0]).max() <= 1.5 * moves


@pytest.mark.parametrize("strides", [0, 2])
def test_on_a_slope_the_camera_and_the_tiles_go_with_the_ground(strides: int):
    scene = msgspec.structs.replace(walk_scene(), ground=Ground(normal=(0.0, 1.0, -0.1)))
    film = make_film(walk_result().replays[0], scene, Look(**SMALL, strides=strides))
    np.testing.assert_allclose(film.followed @ film.ground.plane.normal, 0.0, atol=1e-9)
    assert film.followed[-1, 1] - film.followed[0, 1] > 0.1
    rise = []  # of the tiles on the right of the picture, which is forwards, over those on its left
    for ground in (film.ground, surface(Ground())):
        tiles, _ = Painter(dataclasses.replace(film, ground=ground))._tiles(5)
        across, up = tiles[..., 0].ravel(), tiles[..., 1].ravel()
        rise.append(up[across > 0.3].mean() - up[across < -0.3].mean())
    assert rise[0] > rise[1] + 0.05


def test_films_beside_each_other_have_the_same_scale_and_pace_and_their_names():
    motion = walk_result().replays[0]
    motions = [("short", motion.window(1.0, 1.5), walk_scene()), ("long", motion.window(0.0, 1.0), walk_scene())]
    both = films_beside(motions, Look(width=322, height=120, rate=10.0))
    short, long = both.films
    assert [film.name for film in both.films] == ["short", "long"]
    assert short.camera == long.camera
    np.testing.assert_allclose(short.time, [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.5, 1.5, 1.5, 1.5])
    np.testing.assert_array_equal(both.time, long.time)
    for film in both.films:
        flat, _ = film.camera.project(film.corners(7), film.followed[7])
        assert np.all(np.abs(flat) <= [160.0 / 120.0, 1.0])
    picture = Sheet(both).frame(3)
    assert picture.shape == (120, 322, 3)
    np.testing.assert_array_equal(picture[:, :160], Painter(short, colors=False).frame(3))
    np.testing.assert_array_equal(picture[:, 160:320], Painter(long).frame(3))


def test_many_films_stand_in_rows_as_far_as_there_is_room():
    motion = walk_result().replays[0].window(0.0, 0.2)
    six = films_beside([("a", motion, walk_scene())] * 6, Look(width=320, height=200, rate=10.0))
    assert (six.columns, six.films[0].look.width, six.films[0].look.height) == (3, 106, 100)
    for count, look, message in (
        (17, Look(), "17 motions cannot be seen beside each other"),
        (9, Look(width=128, height=128), "9 motions need a larger picture"),
        (2, Look(strides=2), "gait cycles are shown of one motion"),
    ):
        with pytest.raises(Error, match=message):
            films_beside([("a", motion, walk_scene())] * count, look)


@pytest.mark.parametrize("ending", [".mp4", ".gif", ".webp"])
def test_files_hold_all_frames_at_their_rate(ending: str, film, tmp_path):
    path = tmp_path / f"walk{ending}"
    told = []
    write(film, path, lambda done, total: told.append((done, total)))
    assert told[-1] == (10, 10)
    assert [file.name for file in tmp_path.iterdir()] == [path.name]
    if ending == ".mp4":
        ffmpeg = pytest.importorskip("imageio_ffmpeg")
        assert ffmpeg.count_frames_and_secs(str(path)) == (10, pytest.approx(1.0))
        return
    with Image.open(path) as image:
        assert (image.n_frames, image.size) == (10, (160, 120))
        assert image.info.get("duration", 100) == 100


def test_a_fixed_arm_is_filmed_too(tmp_path):
    film = make_film(arm_motion(), arm(), Look(**SMALL))
    assert Painter(film).frame(0).std() > 1.0
    with pytest.raises(Error, match="no legs to walk on"):
        make_film(arm_motion(), arm(), Look(**SMALL, strides=1))


def test_muscles_without_a_path_are_left_out(film):
    nowhere = dataclasses.replace(film.bellies, start=0 * film.bellies.start)
    pathless = dataclasses.replace(film, muscle_points=film.muscle_points[:, :0], bellies=nowhere)
    assert np.any(Painter(pathless).frame(0) != Painter(film).frame(0))


def test_impossible_wishes_are_refused(film, tmp_path, monkeypatch):
    motion, scene = walk_result().replays[0], walk_scene()
    for wish, message in (
        ({"width": 161}, "even numbers of pixels"),
        ({"rate": 0.0}, "1 to 240 are possible"),
        ({"speed": float("nan")}, "0.001 to 100 are possible"),
        ({"elevation": 90.0}, "-89 to 89 are possible"),
        ({"strides": 40}, "40 gait cycles were asked for"),
    ):
        with pytest.raises(Error, match=message):
            make_film(motion, scene, Look(**(SMALL | wish)))
    with pytest.raises(Error, match="at least two frames"):
        make_film(motion.window(0.0, 0.001), scene)
    with pytest.raises(Error, match=r"a film is written as \.mp4, \.gif, \.webp"):
        write(film, tmp_path / "walk.avi")
    with pytest.raises(Error, match="its folder does not exist"):
        write(film, tmp_path / "nowhere" / "walk.gif")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(Error, match=r"pip install 'warpmuscle\[video\]'"):
        write(film, tmp_path / "walk.mp4")


def test_ground_that_is_not_flat_is_drawn_in_faces_darker_where_they_stand_steep():
    stairs = Ground(terrain=Terrain([Stairs(0.2, tread=0.4, count=3, start=0.5)]))
    film = make_film(walk_result().replays[0], msgspec.structs.replace(walk_scene(), ground=stairs), Look(**SMALL))
    faces, colors = Painter(film)._tiles(5)
    flat, _ = Painter(dataclasses.replace(film, ground=surface(Ground())))._tiles(5)
    assert len(faces) > 2 * len(flat)
    assert np.isfinite(faces).all()
    assert 0.0 <= colors.min() < 0.8
    assert colors.max() <= 1.0


def test_objects_and_water_are_in_the_film_but_do_not_move_its_camera(film):
    objects = {"far": BallObject(position=(0.0, 0.5, 30.0)), "box": BoxObject(position=(0.6, 0.3, 1.0))}
    scene = msgspec.structs.replace(walk_scene(), objects=objects, water=Water(level=0.6))
    motion = walk_result().replays[0].window(1.0, 2.0)
    wet = make_film(motion, scene, Look(**SMALL, rate=10.0))
    np.testing.assert_allclose(wet.bounds, film.bounds)
    np.testing.assert_allclose(wet.position[:, -2:], [[[0.0, 0.5, 30.0], [0.6, 0.3, 1.0]]] * len(wet.time), atol=1e-6)
    box = wet.corners(3)[wet.figure.body == wet.position.shape[1] - 1]
    np.testing.assert_allclose(box.mean(axis=0), [0.6, 0.3, 1.0], atol=1e-6)
    dry, under = Painter(film).frame(0).astype(int), Painter(wet).frame(0).astype(int)
    assert (under[-20:, :, 2] - under[-20:, :, 0]).mean() > (dry[-20:, :, 2] - dry[-20:, :, 0]).mean() + 10


def test_devices_are_drawn_on_the_bodies_that_carry_them():
    motion, scene = walk_result().replays[0].window(1.0, 2.0), walk_scene()
    braced = msgspec.structs.replace(scene, forces={"brace": Force("bilinear_spring", joint="lKnee")})
    plain, with_brace = (make_film(motion, one, Look(**SMALL, rate=10.0)) for one in (scene, braced))
    dark = [np.all(one.figure.tints == (0.16, 0.2, 0.24), axis=1) for one in (plain, with_brace)]
    assert not dark[0].any()
    knee = with_brace.position[3, motion.body_names.index(scene.character.joints["lKnee"].child)]
    assert np.linalg.norm(with_brace.corners(3)[dark[1]] - knee, axis=1).max() < 0.8
    assert np.any(Painter(plain).frame(3) != Painter(with_brace).frame(3))
