"""What is wrong with ground that is not flat is said with its key."""

import math

import numpy as np
import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.scene import Ground, InitialState, Terrain
from warpmuscle.scene.number import Free
from warpmuscle.scene.terrain.packing import packed
from warpmuscle.scene.terrain.tiles import (
    Flat,
    Gaps,
    HeightField,
    Patch,
    Profile,
    Rough,
    Slope,
    Stairs,
    Steps,
    Stones,
    Waves,
)
from warpmuscle.scene.validation.scene import check_scene
from warpmuscle.scene.validation.start import start_warnings

POINTS, TEXT = packed(np.ones((3, 3)))
NAN_POINTS, NAN_TEXT = packed(np.full((3, 3), np.nan))


def checked(ground: Ground) -> None:
    scene = sound_scene()
    scene.ground = ground
    check_scene(scene)


@pytest.mark.parametrize(
    "tile",
    [Flat(), Slope(0.1), Slope(-0.2, 0.0, 1.0), Stairs(-0.1), Steps(), Stones(), Gaps(), Waves(across=1.0), Rough(),
     Profile([(0.0, 0.0), (1.0, 1.0)]), HeightField(size=(1.0, 1.0), points=POINTS, packed=TEXT)],
    ids=lambda tile: type(tile).__name__,
)  # fmt: skip
def test_tiles_of_all_kinds_are_sound_and_written_as_they_are_read(tile):
    checked(Ground(terrain=Terrain([tile], tile=Free(0.0, 0.0, 0.3), scale=0.5, yaw=1.0)))
    scene = sound_scene()
    scene.ground = Ground(terrain=Terrain([tile, Flat(patches=[Patch((0.0, 1.0), (0.0, 1.0), friction=0.1)])]))
    assert toml.loads(toml.dumps(scene)).ground == scene.ground


@pytest.mark.parametrize(
    ("tile", "key", "words"),
    [
        (Slope(1.5), "angle", "steeper"),
        (Slope(math.nan), "angle", "finite"),
        (Slope(0.1, length=1.0), "start", "has a start"),
        (Stairs(tread=0.0), "tread", "greater than 0"),
        (Stairs(count=0), "count", "from 1 to"),
        (Stairs(count=10**9), "count", "from 1 to"),
        (Stairs(riser=1e-9), "", "limit `tiles`"),
        (Stairs(rise=1e6), "rise", "at most 10000 m"),
        (Steps(length=-1.0), "length", "greater than 0"),
        (Steps(seed=-1), "seed", "negative"),
        (Stones(size=(0.3, 0.0)), "size.1", "greater than 0"),
        (Stones(count=(9999, 9999)), "", "limit `tiles`"),
        (Gaps(width=0.5, spacing=0.5), "spacing", "greater than the width"),
        (Waves(points=1), "points", "from 4 to"),
        (Rough(count=(1, 5)), "count.0", "from 2 to"),
        (Rough(count=(10_000, 10_000)), "", "limit `tiles`"),
        (Profile([(0.0, 0.0)]), "corners", "two corners"),
        (Profile([(0.0, 0.0), (0.0, 1.0)]), "corners.1", "increase"),
        (Profile([(0.0, 0.0), (0.001, 1.0)]), "corners.1", "nearer"),
        (HeightField(), "file", "from a file"),
        (HeightField(points=POINTS, packed=TEXT), "size.0", "has a size"),
        (HeightField(size=(1.0, 1.0), points=(3, 4), packed=TEXT), "packed", "not those of a grid of 3 x 4"),
        (HeightField(size=(1.0, 1.0), points=POINTS, packed="!" + TEXT), "packed", "damaged"),
        (HeightField(size=(1.0, 1.0), points=(-3, 3), packed=TEXT), "points.0", "from 2 to"),
        (HeightField(size=(1.0, 1.0), points=(2**20, 3), packed=TEXT), "points", "limit `heights`"),
        (HeightField(size=(1.0, 1.0), points=NAN_POINTS, packed=NAN_TEXT), "packed", "finite"),
        (Flat(patches=[Patch((1.0, 0.0), (0.0, 1.0))]), "patches.0.x", "greater than high"),
        (Flat(patches=[Patch((0.0, 1.0), (0.0, 1.0), friction=-1.0)]), "patches.0.friction", "negative"),
        (Flat(patches=[Patch((0.0, 1.0), (0.0, 1.0), stiffness=0.0)]), "patches.0.stiffness", "greater than 0"),
    ],
)
def test_what_is_wrong_with_a_tile_is_said_with_its_key(tile, key: str, words: str):
    with pytest.raises(SceneError, match=words) as error:
        checked(Ground(terrain=Terrain([tile])))
    assert error.value.key == f"ground.terrain.tiles.0.{key}".rstrip(".")


@pytest.mark.parametrize(
    ("ground", "key", "words"),
    [
        (Ground(terrain=Terrain([])), "ground.terrain.tiles", "no tile"),
        (Ground(terrain=Terrain([Flat()], tile=1.0)), "ground.terrain.tile", "numbered from 0 to 0"),
        (Ground(terrain=Terrain([Flat()], tile=Free(0.0, -1.0, 0.0))), "ground.terrain.tile", "numbered"),
        (Ground(terrain=Terrain([Flat()], scale=-1.0)), "ground.terrain.scale", "negative"),
        (Ground(normal=(0.0, 0.0, 1.0), terrain=Terrain([Flat()])), "ground.normal", "upwards"),
        (Ground(law="soft_constraint", terrain=Terrain([Flat(patches=[Patch((0, 1), (0, 1), stiffness=2.0)])])),
         "ground.terrain.tiles.0.patches.0", "friction alone"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_where_tiles_lie_is_said_with_its_key(ground: Ground, key: str, words: str):
    with pytest.raises(SceneError, match=words) as error:
        checked(ground)
    assert error.value.key == key


def test_an_unknown_kind_is_named_with_those_that_there_are():
    text = toml.dumps(sound_scene()) + '\n[[ground.terrain.tiles]]\ntype = "mountain"\n'
    with pytest.raises(SceneError, match="mountain"):
        toml.loads(text)


def test_a_character_that_starts_in_the_ground_is_warned_of_and_one_that_is_raised_is_not():
    scene = sound_scene()
    scene.initial_state = InitialState((0.0, 1.5, 0.0))
    steep = [Stairs(0.6, start=0.4, count=1)]  # a foot, 2 m long, reaches into the step
    scene.ground = Ground(terrain=Terrain(steep, clearing=0.0))
    (warning,) = start_warnings(scene)
    assert "deep in the ground" in str(warning)
    scene.ground = Ground(terrain=Terrain(steep, clearing=1.0))
    assert start_warnings(scene) == []
