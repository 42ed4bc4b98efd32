"""Lengths, tensions and torques of muscles on pulleys and through points, for sets of parameters, in float64."""

import numpy as np
import pytest

from muscle_arm import arm
from warpmuscle.core.errors import SceneError
from warpmuscle.scene import Muscle, MuscleModel, Scene
from warpmuscle.scene.muscles import Pulley
from warpmuscle.simulation.stages import Stages
from warpmuscle.studies.moment_arms import muscle_geometry
from warpmuscle.studies.muscle_table import MuscleTable, PathGeometry

ANGLE, SPEED = np.array([[-0.4], [0.1], [0.5]]), np.array([[1.0], [-2.0], [0.0]])
L_OPT, L_SLACK, F_MAX = 0.15, 0.1, np.array([400.0, 600.0])
V_MAX, DAMPING = 9.0, 0.05


def scene_of(through_points: bool) -> Scene:
    """An arm with two muscles on pulleys, and with or without one in front through points."""
    scene = arm()
    flexor = scene.character.muscles["flexor"]
    pulley = {"l_opt": L_OPT, "l_slack": L_SLACK}
    scene.character.muscles = {
        "up": Muscle(
            f_max=F_MAX, rest_length=0.26, pulleys=[Pulley("elbow", np.array([0.03, 0.05]), rest_angle=0.2)], **pulley
        ),
        "down": Muscle(f_max=500.0, rest_length=0.24, pulleys=[Pulley("elbow", -0.02)], **pulley),
    } | ({"flexor": flexor} if through_points else {})
    scene.muscle_model = MuscleModel(v_max=V_MAX, damping=DAMPING)
    return scene


def table_of(scene: Scene) -> tuple[MuscleTable, np.ndarray]:
    """The table of two sets of parameters, and the pose."""
    first = Stages(arm(), 1, "cpu").names.coordinate_start[1]
    pose = np.zeros(first + 1)
    pose[6] = 1.0
    geometry = PathGeometry(arm(), pose, [first], [0])
    return MuscleTable.of(scene, ["elbow"], 2, geometry), pose


def tension(activation: float, length: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Over f_max, of Lee's curves and a rigid tendon."""
    x, v = (length - L_SLACK) / L_OPT, np.clip(rate / (L_OPT * V_MAX), -1.0, 1.0)
    lengthening = v * (2.0 + 2.0 / 0.3)
    f_v = np.where(v <= 0.0, (1.0 + v) / (1.0 - v / 0.3), (1.8 * lengthening + 0.8) / (lengthening + 0.8))
    passive = np.where(x > 1.0, np.expm1(4.0 * (x - 1.0) / 0.6) / np.expm1(4.0), 0.0)
    return np.maximum(activation * np.exp(-((x - 1.0) ** 2) / 0.5) * f_v + passive + DAMPING * v, 0.0)


def test_tensions_and_torques_on_pulleys_are_those_of_their_formulas():
    table, _ = table_of(scene_of(through_points=False))
    arms = np.array([[0.03, -0.02], [0.05, -0.02]])
    length = np.array([0.26, 0.24]) - arms[:, None] * (ANGLE[None] - [0.2, 0.0])
    got_length, got_arm = table.paths(ANGLE)
    np.testing.assert_allclose(got_length, length, atol=1e-12)
    np.testing.assert_allclose(np.broadcast_to(got_arm[..., 0], (2, 3, 2)), np.repeat(arms[:, None], 3, axis=1))
    rate = -arms[:, None] * SPEED[None]
    f_max = np.stack([F_MAX, [500.0, 500.0]], axis=1)[:, None]
    for activation in (0.0, 0.6):
        expected = f_max * tension(activation, length, rate)
        force = table.forces(activation, ANGLE, SPEED)
        np.testing.assert_allclose(force, expected, rtol=1e-4, atol=1e-2)
        torque = table.torques(activation, ANGLE, SPEED)
        np.testing.assert_allclose(torque[..., 0], expected * arms[:, None], rtol=1e-4, atol=1e-3)
    each = np.array([[0.2, 0.9], [0.5, 0.1], [1.0, 0.4]])
    expected = np.stack([f_max[:, 0, m, None] * tension(each[:, m], length[..., m], rate[..., m]) for m in (0, 1)], -1)
    np.testing.assert_allclose(table.forces(each, ANGLE, SPEED), expected, rtol=1e-4, atol=1e-2)


def test_muscles_through_points_take_their_lengths_and_arms_from_the_geometry():
    scene = scene_of(through_points=True)
    table, pose = table_of(scene)
    assert table.through_points == (2,)
    geometry = table.geometry
    geometry.scene.character.muscles = {"a": geometry.scene.character.muscles["extensor"]} | {
        "b": geometry.scene.character.muscles["extensor"], "c": geometry.scene.character.muscles["flexor"],
    }  # fmt: skip
    poses = np.tile(pose, (3, 1))
    poses[:, -1] = ANGLE[:, 0]
    lengths, arms = muscle_geometry(geometry.scene, poses)
    got_length, got_arm = table.paths(ANGLE)
    np.testing.assert_allclose(got_length[:, :, 2], np.tile(lengths[:, 2], (2, 1)), atol=1e-9)
    np.testing.assert_allclose(got_arm[:, :, 2], np.tile(arms[:, 2], (2, 1, 1)), atol=1e-9)
    np.testing.assert_allclose(got_arm[:, :, 0, 0], [[0.03] * 3, [0.05] * 3])
    assert geometry.at(ANGLE) is geometry.at(ANGLE.copy())
    for k in range(9):
        geometry.at(ANGLE + 0.01 * (k + 1))
    assert len(geometry._found) == 8


def test_a_muscle_on_pulleys_without_a_rest_length_is_refused():
    scene = scene_of(through_points=False)
    scene.character.muscles["up"].rest_length = None
    with pytest.raises(SceneError, match="a muscle on pulleys has a rest length"):
        table_of(scene)
