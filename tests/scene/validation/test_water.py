"""What is wrong with water is said with its key."""

import pytest

from small_scene import sound_scene
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import toml
from warpmuscle.scene import Water
from warpmuscle.scene.number import Free
from warpmuscle.scene.validation.scene import check_scene


def checked(water: Water, shapes: bool = True) -> None:
    scene = sound_scene()
    scene.water = water
    for body in scene.character.bodies.values():
        body.shapes = body.shapes if shapes else []
    check_scene(scene)


def test_water_is_written_as_it_is_read():
    scene = sound_scene()
    scene.water = Water(level=Free(0.5, 0.0, 1.0), volume="shapes", current=-0.2)
    check_scene(scene)
    assert toml.loads(toml.dumps(scene)).water == scene.water


@pytest.mark.parametrize(
    ("values", "key", "says"),
    [
        ({"density": 0.0}, "density", "greater than 0"),
        ({"density": 1e6}, "density", "100000"),
        ({"body_density": 0.01}, "body_density", "1 kg/m"),
        ({"drag": -1.0}, "drag", "not be negative"),
        ({"axial_drag": Free(0.0, -1.0, 1.0)}, "axial_drag", "not be negative"),
        ({"added_mass": -0.1}, "added_mass", "not be negative"),
        ({"level": float("inf")}, "level", "finite"),
    ],
)
def test_what_is_wrong_is_said_with_its_key(values, key: str, says: str):
    with pytest.raises(SceneError, match=says) as error:
        checked(Water(**values))
    assert error.value.key == f"water.{key}"


def test_bodies_without_shapes_have_no_volume_by_them():
    with pytest.raises(SceneError, match="no body has a shape") as error:
        checked(Water(volume="shapes"), shapes=False)
    assert error.value.key == "water.volume"
