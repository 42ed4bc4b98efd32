"""What is wrong with a treadmill is said with its key."""

import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.scene import Ground, Terrain, Treadmill
from warpmuscle.scene.number import Free
from warpmuscle.scene.terrain.tiles import Flat
from warpmuscle.scene.validation.scene import check_scene


def checked(treadmill: Treadmill, **ground) -> None:
    scene = sound_scene()
    scene.ground = Ground(treadmill=treadmill, **ground)
    check_scene(scene)


def test_a_treadmill_is_written_as_it_is_read():
    scene = sound_scene()
    scene.ground = Ground(treadmill=Treadmill(speed=Free(1.0, 0.0, 2.0), left=0.3, profile=[(0.0, 1.0), (0.5, -1.0)]))
    check_scene(scene)
    assert toml.loads(toml.dumps(scene)).ground == scene.ground


@pytest.mark.parametrize(
    ("values", "key", "says"),
    [
        ({"speed": 101.0}, "speed", "100 m/s at most"),
        ({"left": Free(0.0, -200.0, 1.0)}, "left", "100 m/s at most"),
        ({"start": float("nan")}, "start", "finite"),
        ({"profile": [(0.0, 1.0), (0.0, 2.0)]}, "profile.1", "must increase"),
        ({"profile": [(0.0, 1e3)]}, "profile.0", "a factor of 100"),
        ({"profile": [(float("inf"), 1.0)]}, "profile.0.0", "finite"),
    ],
)
def test_what_is_wrong_is_said_with_its_key(values, key: str, says: str):
    with pytest.raises(SceneError, match=says) as error:
        checked(Treadmill(**values))
    assert error.value.key == f"ground.treadmill.{key}"


def test_belts_are_flat_and_lie():
    with pytest.raises(SceneError, match="belts are flat"):
        checked(Treadmill(), terrain=Terrain([Flat()]))
    with pytest.raises(SceneError, match="point upwards"):
        checked(Treadmill(), normal=(0.0, -1.0, 0.0))
