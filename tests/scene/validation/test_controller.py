"""What a controller of legs needs of a character is said in one line, with its key."""

from collections.abc import Callable

import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.scene import Scene
from warpmuscle.scene.validation.scene import check_scene


def no_feet(scene: Scene) -> None:
    scene.character.feet = None


def foot_at_the_root(scene: Scene) -> None:
    scene.character.feet = ("lUpperleg", "rFoot")


def no_hinge(scene: Scene) -> None:
    scene.character.joints["lKnee"].type = "ball"
    scene.character.joints["lKnee"].axes = [(1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]
    scene.character.joints["lKnee"].limits = []


def hip_of_the_trunk(scene: Scene) -> None:
    scene.character.joints["lHip"].parent = "torso"


def slide(scene: Scene) -> None:
    scene.character.joints["lElbow"].type = "slide"
    scene.character.joints["lElbow"].limits = []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (no_feet, "character.feet: a controller of type 'walking' needs the two feet: name them"),
        (foot_at_the_root, "character.feet: a controller of type 'walking' needs a knee between the root and 'lUpper"),
        (no_hinge, "character.joints.lKnee: a controller of type 'walking' needs a hinge as knee"),
        (hip_of_the_trunk, "character.joints.lHip.parent: .* needs hips of the root, and 'lHip' has 'torso' above it"),
        (slide, "character.joints.lElbow.type: a controller of type 'walking' can move only joints of type ball"),
    ],
)  # fmt: skip
def test_a_character_without_two_legs_is_refused(change: Callable[[Scene], None], message: str):
    scene = load("steer")
    change(scene)
    with pytest.raises(SceneError, match=message) as caught:
        check_scene(scene)
    assert "\n" not in str(caught.value)
