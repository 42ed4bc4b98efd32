"""Motion of objects is found in recordings by its names."""

from types import SimpleNamespace

import numpy as np
import pytest

from warpmuscle.core.errors import ArgumentError
from warpmuscle.scene.objects.motion import is_recorded, object_motion, object_quantities


def test_the_motion_of_an_object_is_found_among_all_that_is_recorded():
    names = ("mine", *object_quantities("box"), *object_quantities("ball"))
    values = np.arange(2 * len(names), dtype=float).reshape(2, -1)
    motion = object_motion(SimpleNamespace(recorded_names=names, recorded=values), "ball")
    assert motion.position[0].tolist() == [14.0, 15.0, 16.0]
    assert motion.orientation[1].tolist() == [44.0, 45.0, 46.0, 47.0]
    assert motion.velocity[0].tolist() == [21.0, 22.0, 23.0]
    assert motion.angular_velocity[0, 2] == 26.0


def test_an_object_that_was_not_recorded_is_named_beside_those_that_were():
    recording = SimpleNamespace(recorded_names=("mine", *object_quantities("box")), recorded=np.zeros((2, 14)))
    assert is_recorded(recording, "box")
    assert not is_recorded(recording, "ball")
    with pytest.raises(ArgumentError, match="of an object 'ball' was recorded, but of box"):
        object_motion(recording, "ball")
