"""Motion of objects is found in recordings by its names."""

from types import SimpleNamespace

import numpy as np

from warpmuscle.scene.objects.motion import object_motion, object_quantities


def test_the_motion_of_an_object_is_found_among_all_that_is_recorded():
    names = ("mine", *object_quantities("box"), *object_quantities("ball"))
    values = np.arange(2 * len(names), dtype=float).reshape(2, -1)
    motion = object_motion(SimpleNamespace(recorded_names=names, recorded=values), "ball")
    assert motion is not None
    assert motion.position[0].tolist() == [14.0, 15.0, 16.0]
    assert motion.orientation[1].tolist() == [44.0, 45.0, 46.0, 47.0]
    assert motion.velocity[0].tolist() == [21.0, 22.0, 23.0]
    assert motion.angular_velocity[0, 2] == 26.0
    assert object_motion(SimpleNamespace(recorded_names=("mine",), recorded=values), "ball") is None
