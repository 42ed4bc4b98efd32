"""A motion seen from the belts of a treadmill is one over the ground."""

import msgspec
import numpy as np

from small_result import walk_result, walk_scene
from warpmuscle.gait.measures import measure
from warpmuscle.gait.relative_to_belts import over_belts
from warpmuscle.gait.sides import measures_of_sides
from warpmuscle.scene import Treadmill
from warpmuscle.scene.parameters import start_values, substitute
from warpmuscle.scene.treadmill.belt_motion import mean_shift


def test_a_walk_on_a_treadmill_measures_as_the_same_walk_over_the_ground():
    ground, walk = substitute(walk_scene(), start_values(walk_scene())), walk_result().replays[0]
    treadmill = Treadmill(speed=0.5, left=0.2, right=0.6, sideways=0.1)
    belt = msgspec.structs.replace(ground, ground=msgspec.structs.replace(ground.ground, treadmill=treadmill))
    shift = mean_shift(belt.ground, walk.time)
    on_belt = walk.changed(
        com=(walk.com + shift).astype(np.float32), root_position=(walk.root_position + shift).astype(np.float32),
        body_position=(walk.body_position + shift[:, None]).astype(np.float32),
    )  # fmt: skip
    back = over_belts(on_belt, belt)
    np.testing.assert_allclose(back.com, walk.com, atol=1e-5)
    assert over_belts(walk, ground) is walk
    there, here = measure(on_belt, belt), measure(walk, ground)
    assert abs(there.step_length - here.step_length) < 1e-4
    steps, same = measures_of_sides(on_belt, belt)["step length"], measures_of_sides(walk, ground)["step length"]
    assert np.abs(np.subtract(steps[1:], same[1:])).max() < 1e-4
    assert there.speed_forward == here.speed_forward  # which is recorded relative to the belts
