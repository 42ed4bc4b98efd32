"""What the walking controller measures of its body, against the scene's own numbers."""

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.kernels.control.walking import parameters as places
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.parameters import at_start
from warpmuscle.scene.validation.damping import leg_length
from warpmuscle.simulation.rollout import Rollout


def test_foot_and_leg_are_as_long_as_the_scene_has_them():
    """Soles reach as far from the ankle as all points of contact of foot and toes."""
    rollout = Rollout(load("steer"), 1, "cpu")
    rollout.run(rollout.scene.time_step)
    memory = rollout._extensions.struct.first.memory.numpy()[0, 0].astype(float)
    character = rollout.numeric.character
    foot = character.feet[0]
    joints = {joint.child: joint for joint in character.joints.values()}
    places_of, radii = [], []
    for name in [foot, *(joint.child for joint in joints.values() if joint.parent == foot)]:
        own = joints[name]
        origin = np.zeros(3) if name == foot else np.array(own.position_in_parent) - joints[foot].position_in_child
        for shape in character.bodies[name].shapes:
            for point, radius in contact_points(shape):
                places_of.append(origin + np.array(point) - own.position_in_child)
                radii.append(radius)
    point, radius = np.array(places_of, dtype=float), np.array(radii, dtype=float)
    sole = (radius - point[:, 1]).max()
    shank = joints[foot].parent
    lengths = [
        np.linalg.norm(np.subtract(joints[one].position_in_parent, joints[joints[one].parent].position_in_child))
        for one in (foot, shank)
    ]
    expected = {
        places.SOLE: sole, places.HEEL: (point[:, 2] - radius).min(), places.TOE: (point[:, 2] + radius).max(),
        places.HALF_WIDTH: (np.abs(point[:, 0]) + radius).max(), places.LEG: sum(lengths) + sole,
    }  # fmt: skip
    for place, value in expected.items():
        np.testing.assert_allclose(memory[int(place)], value, rtol=1e-4)
    assert leg_length(at_start(load("steer"))) == pytest.approx(expected[places.LEG], rel=1e-9)


def test_who_stands_has_forgotten_how_it_walked():
    rollout = Rollout(load("steer"), 1, "cpu")
    rollout.set_commands({"speed": 0.0})
    rollout.run(rollout.scene.time_step)
    floats = rollout._extensions.struct.first.memory
    memory, forgotten = floats.numpy(), [int(one) for one in (places.SPEED, places.TUNED, places.WAY, places.SINCE)]
    assert memory[0, 0, int(places.STANCE)] == float(places.STANDS)
    memory[0, 0, forgotten] = 0.3
    floats.assign(memory)
    rollout.run(rollout.scene.time_step)
    np.testing.assert_array_equal(floats.numpy()[0, 0, forgotten], 0.0)
