"""Slides, drags and depths of feet that are moved by hand."""

import numpy as np
import pytest

from muscle_arm import arm
from small_result import march, walk_scene, with_arrays
from warpmuscle.core.errors import Error
from warpmuscle.core.pose import about
from warpmuscle.gait.cycles import body_weight
from warpmuscle.gait.foot_sliding import FootSliding, foot_sliding
from warpmuscle.scene import Scene
from warpmuscle.scene.parameters import start_values, substitute

SOLE = 0.033  # m, of the foot's box below its centre of mass
RADIUS, CENTER = 0.01, np.array([0.0, -0.005, 0.025])  # m, of the sphere of the toes


@pytest.fixture(scope="module")
def scene() -> Scene:
    """The biped that walks on torques."""
    plain = walk_scene("fwalk")
    return substitute(plain, start_values(plain))


def contact(scene: Scene, load: np.ndarray, turned: float = 0.0, **bodies: np.ndarray) -> FootSliding:
    """The contact of feet in the air but for these bodies at (F, 3); the left foot carries (F,) body weights.

    Args:
        turned: rad, by which the toes turn about x over the motion.
    """
    motion = march(scene.character, 1.0, 1.0, 101)
    place, orientation = motion.body_position.copy(), np.zeros_like(motion.body_orientation)
    orientation[..., 3] = 1.0
    orientation[:, motion.body_names.index("lToes")] = about([1.0, 0.0, 0.0], turned * motion.time)
    for name in ("lFoot", "rFoot", "lToes", "rToes"):
        place[:, motion.body_names.index(name)] = bodies.get(name, np.tile([0.0, 1.0, 0.0], (101, 1)))
    force = np.stack([0.0 * load, load * body_weight(scene), 0.0 * load], axis=1)
    return foot_sliding(
        with_arrays(motion, body_position=place, body_orientation=orientation, foot_force_left=force,
                    foot_force_right=0.0 * force),
        scene,
    )  # fmt: skip


def path(x: float | np.ndarray, y: float | np.ndarray, z: float | np.ndarray) -> np.ndarray:
    """Places (101, 3), m."""
    return np.stack([np.broadcast_to(part, 101) for part in (x, y, z)], axis=1).astype(float)


TIME = np.linspace(0.0, 1.0, 101)


def test_a_loaded_foot_slides_as_far_as_it_is_moved_and_is_as_deep_as_it_is_put(scene: Scene):
    found = contact(scene, np.ones(101), lFoot=path(0.04 * TIME, SOLE - 0.002, 0.03 * TIME))
    assert found.greatest_slide == pytest.approx(0.05)
    assert found.mean_slide == pytest.approx(0.05)
    assert found.mean_drag == 0.0
    assert found.depth == pytest.approx(0.002)


def test_a_foot_that_comes_back_has_slid_as_far_as_it_was_away(scene: Scene):
    away = 0.02 * np.sin(np.pi * TIME)
    assert contact(scene, np.ones(101), lFoot=path(0, SOLE - 0.001, away)).greatest_slide == pytest.approx(0.02)


def test_a_foot_in_the_air_does_not_slide(scene: Scene):
    assert contact(scene, np.ones(101), lFoot=path(0, SOLE + 0.001, TIME)) == FootSliding(0.0, 0.0, 0.0, 0.0)


def test_what_slides_without_load_is_a_drag_and_each_step_counts(scene: Scene):
    load = np.where(TIME < 0.205, 1.0, np.where(TIME < 0.605, 0.1, 0.8))
    moved = np.interp(TIME, [0.2, 0.21, 0.6, 0.61, 1.0], [0.0, 0.0, 0.2, 0.2, 0.21])
    found = contact(scene, load, lFoot=path(0, SOLE - 0.001, moved))
    assert found.mean_drag == pytest.approx(0.2 / 2, abs=1e-3)  # the other foot hangs in the air, and drags by nothing
    assert found.greatest_slide == pytest.approx(0.01, abs=1e-3)
    assert found.mean_slide == pytest.approx(0.005, abs=1e-3)


def test_toes_that_roll_do_not_slide(scene: Scene):
    angle = 0.8  # rad; about x, so that the lowest point would go backwards, and the sphere rolls forwards
    turn = about([1.0, 0.0, 0.0], angle * TIME)
    center = path(0, RADIUS - 0.001, RADIUS * angle * TIME)
    y, z = CENTER[1], CENTER[2]
    cosine, sine = np.cos(angle * TIME), np.sin(angle * TIME)
    offset = np.stack([0.0 * TIME, cosine * y - sine * z, sine * y + cosine * z], axis=1)
    assert turn.shape == (101, 4)
    found = contact(scene, np.ones(101), angle, lToes=center - offset)
    assert found.greatest_slide < 1e-5
    assert found.depth == pytest.approx(0.001)
    slid = contact(scene, np.ones(101), angle, lToes=center - offset + path(0, 0, 0.03 * TIME))
    assert slid.greatest_slide == pytest.approx(0.03, abs=1e-5)


def test_a_scene_without_feet_is_an_error():
    with pytest.raises(Error, match="no legs"):
        foot_sliding(march(walk_scene("fwalk").character, 1.0), arm())
