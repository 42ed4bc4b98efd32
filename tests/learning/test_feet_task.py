"""The feet of gait2392_arms_feet touch the ground where contact spheres of predictive simulations do."""

import numpy as np
import pytest

from warpmuscle import load
from warpmuscle.core.number_rows import first_row
from warpmuscle.examples import write
from warpmuscle.learning.player import task_of
from warpmuscle.results.result import read
from warpmuscle.scene import Scene
from warpmuscle.scene.geometry import contact_points
from warpmuscle.scene.parameters import at_start

# Hamner's model as Falisse scaled it (predsim_tutorial, Hamner_modified_scaled.cpp): forwards and to the right of the
# origin of the right calcn, m: heel, first and fifth metatarsal head, outer edge; and where the toes' joint is.
SPHERES = ((0.0019, -0.0038), (0.1484, -0.0287), (0.1330, 0.0516), (0.0662, 0.0264))
TOES = 0.1634
HEEL, FIRST, FIFTH, EDGE = range(4)


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Scene:
    folder = tmp_path_factory.mktemp("feet")
    write("policies", folder)
    return at_start(load(str(folder / "gait2392_arms_feet.toml")))


def places(scene: Scene, body: str) -> np.ndarray:
    """Contact points (n, 4) of a body: their places, m, and radii."""
    shapes = scene.character.bodies[body].shapes
    return np.array([[*place, radius] for shape in shapes for place, radius in contact_points(shape)])


def ahead_of_ankle(scene: Scene, along: float) -> float:
    """How far a place along the right calcn is ahead of the ankle, m, in the reference pose."""
    subtalar = scene.character.joints["subtalar_angle_r"]
    return along - float(first_row(subtalar.position_in_child)[2]) + float(first_row(subtalar.position_in_parent)[2])


def test_contacts_are_as_far_along_the_foot_as_the_spheres(scene: Scene):
    toes = first_row(scene.character.joints["mtp_angle_r"].position_in_parent)[2]
    origin = first_row(scene.character.joints["subtalar_angle_r"].position_in_child)[2]  # of OpenSim's calcn
    share = (places(scene, "calcn_r")[:, 2] - origin) / (toes - origin)
    expected = np.array(SPHERES)[:, 0] / TOES
    np.testing.assert_allclose(share, expected[[HEEL, HEEL, FIFTH, FIRST, EDGE]], atol=0.005)
    across = -places(scene, "calcn_r")[[2, 3, 4], 0]  # to the right
    np.testing.assert_allclose(across, np.array(SPHERES)[[FIFTH, FIRST, EDGE], 1], atol=0.001)


def test_the_ball_is_ten_to_eleven_centimetres_ahead_of_the_ankle_not_thirteen(scene: Scene):
    ball = [ahead_of_ankle(scene, z) for z in places(scene, "calcn_r")[[2, 3], 2]]
    assert ball == pytest.approx([0.097, 0.114], abs=0.001)
    edge = places(at_start(load("gait2392_arms")), "calcn_r")[:, 2].max()
    assert ahead_of_ankle(scene, edge) == pytest.approx(0.131, abs=0.001)


def test_both_feet_are_mirror_images_with_a_sole_as_deep_as_before(scene: Scene):
    left, right = places(scene, "calcn_l"), places(scene, "calcn_r")
    np.testing.assert_array_equal(left * [-1.0, 1.0, 1.0, 1.0], right)
    box = places(at_start(load("gait2392_arms")), "calcn_r")
    np.testing.assert_allclose((right[:, 1] - right[:, 3]), box[:, 1].min(), atol=1e-9)


def test_toes_are_held_less_stiffly_than_before_and_more_than_at_rest(scene: Scene):
    held = {side: float(np.ravel(scene.actuation[f"mtp_angle_{side}"].stiffness)[0]) for side in "lr"}
    assert held["l"] == held["r"]
    at_rest = 0.0149 * 180.0 / np.pi  # N m/rad, of a big toe (Heng 2016, J. Foot Ankle Res. 9:41)
    before = at_start(load("gait2392_arms")).actuation["mtp_angle_r"].stiffness
    assert at_rest < held["r"] < float(np.ravel(before)[0])


def test_soles_give_by_less_than_half_of_a_heel_pad(scene: Scene):
    weight = 9.81 * sum(float(np.ravel(body.mass)[0]) for body in scene.character.bodies.values())
    heel = 2.0 * float(np.ravel(scene.ground.stiffness)[0])  # of its two points
    assert 0.004 < weight / heel < 0.5 * 0.016  # m; a heel's pad is 16 mm thick


def test_the_policy_was_learnt_in_this_scene_and_task(scene: Scene, tmp_path):
    write("policies", tmp_path)
    learned = read(tmp_path / "gait2392_arms_feet.h5").learned
    assert learned is not None
    assert task_of(learned) == scene.learning
