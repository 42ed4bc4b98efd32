"""Plain data into typed data: errors name the key, hidden table keys included, and use plain words."""

import datetime

import msgspec
import pytest

from small_scene import sound_scene
from warpmuscle.core.decoding import to_type
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Scene

FOOT = ["character", "bodies", "rFoot"]
COMPONENT = ["controller", "states", 0, "trajectories", "SWING_Hip", "components", 0]


def test_data_of_a_sound_scene_gives_the_scene():
    assert to_type(msgspec.to_builtins(sound_scene()), Scene) == sound_scene()


@pytest.mark.parametrize(
    ("path", "value", "key", "message"),
    [
        ([*FOOT, "mass"], "heavy", "", "expected a number, got text"),
        ([*FOOT, "mass"], True, "", "expected a number, got true or false"),
        ([*FOOT, "mass"], 10**400, "", "number out of range"),
        ([*FOOT, "mass"], {"value": 3, "min": 4, "max": 5}, "", "value 3 is outside its interval [4, 5]"),
        ([*FOOT, "mass"], {"value": 3, "mix": 4}, ".mix", "unknown key; did you mean 'min'? known keys: value, min"),
        ([*FOOT, "mas"], 1, "", "unknown key; did you mean 'mass'? known keys: mass, inertia, shapes, friction"),
        ([*FOOT, "inertia"], [1, 2], "", "expected 3 values, got 2"),
        ([*FOOT, "inertia"], [1, 2, "x"], ".2", "expected a number, got text"),
        ([*FOOT, "shapes"], [{"type": "cone"}], ".0.type", "'cone' is none of 'sphere', 'capsule', 'box'"),
        ([*FOOT, "shapes"], [{"radius": 1}], ".0", "missing key 'type'"),
        ([*FOOT, "shapes"], [{"type": "box", "radius": 1}], ".0.radius", "unknown key; known keys: type, low, high"),
        (
            ["forces"],
            {"cord": {"type": "point_spring", "rest": 1}},
            ".cord.rest",
            "numbers of its kind belong into parameters = { rest = ... }; known keys: type, joint, body",
        ),
        (["forces"], {"cord": {"typo": "point_spring"}}, ".cord.typo", "did you mean 'type'?"),
        (FOOT, [1], "", "expected a table, got a list"),
        ([*COMPONENT, "reverse_on"], "lft", "", "'lft' is none of 'left', 'never', 'right'; did you mean 'left'?"),
        ([*COMPONENT, "feedback"], 3, "", "expected a table, got a whole number"),
        ([*COMPONENT, "axis"], datetime.date(2000, 1, 1), "", "expected a list, got a date"),
        (["controller", "start_state"], 0.5, "", "expected a whole number, got a number"),
    ],
)
def test_what_does_not_fit_is_named(path, value, key, message):
    data = msgspec.to_builtins(sound_scene())
    part = data
    for name in path[:-1]:
        part = part[name]
    part[path[-1]] = value
    with pytest.raises(SceneError) as caught:
        to_type(data, Scene)
    assert caught.value.key == ".".join(map(str, path)) + key
    assert message in caught.value.message


def test_keys_may_be_put_below_another():
    with pytest.raises(SceneError, match=r"^scene: missing key 'name'"):
        to_type({}, Scene, key="scene")
