"""Fibres and forces of all muscles in frames of a motion: those of a ligament, which has no fibre, beside muscles."""

import numpy as np
import pytest
import warp as wp

from muscle_arm import leg
from warpmuscle.core.arrays import to_device
from warpmuscle.kernels import structs
from warpmuscle.kernels.inverse.muscle_moments import fibre_forces_of
from warpmuscle.model.build import with_fields
from warpmuscle.model.muscles import muscle_kind, muscles_struct
from warpmuscle.scene import Ligament, MuscleModel

NAMES, LENGTHS, SPEED = ("both", "hip", "knee"), [0.2, 0.3], 0.4  # m, m/s


def test_a_ligament_counts_as_a_fibre_at_rest_and_muscles_move_as_their_paths_do():
    """A tension of the strain (0.2 and 0.3 m over 0.15 m) times f_max; fibres of rigid tendons are as fast as paths."""
    scene = leg(muscle_model=MuscleModel(curves="millard"))
    strap = scene.character.muscles["hip"]
    strap.l_slack, strap.f_max = 0.15, 500.0
    strap.curve_shape = Ligament([1.0, 3.0], [0.0, 2.0], ends="linear")
    kind = muscle_kind(scene.muscle_model, scene.character.muscles.values())
    model = with_fields(structs.Model(), {"muscles": muscles_struct(scene, NAMES, "cpu")})
    length = to_device(np.repeat(np.array(LENGTHS)[:, None], 3, axis=1), float, "cpu")
    speed, none = to_device(np.full((2, 3), SPEED), float, "cpu"), wp.zeros((0, 0, 0), dtype=float, device="cpu")
    fibre = to_device(np.full((2, 2, 3), 7.0), float, "cpu")
    active, passive = (to_device(np.full((2, 3), 7.0), float, "cpu") for _ in range(2))
    kernel = fibre_forces_of(kind.curves, kind.special_curves)
    wp.launch(kernel, (2, 3), [model, none, length, speed], [fibre, active, passive], device="cpu")
    np.testing.assert_array_equal(fibre.numpy()[:, :, 1], [[1.0, 1.0], [0.0, 0.0]])
    np.testing.assert_array_equal(active.numpy()[:, 1], 0.0)
    np.testing.assert_allclose(passive.numpy()[:, 1], 500.0 * (np.array(LENGTHS) / 0.15 - 1.0), rtol=1e-5)
    muscle = scene.character.muscles["both"]
    np.testing.assert_allclose(fibre.numpy()[0, :, 0], (np.array(LENGTHS) - muscle.l_slack) / muscle.l_opt, rtol=1e-5)
    fastest = model.muscles.row.numpy()[0, 0]["v_max"] * muscle.l_opt
    assert fibre.numpy()[1, 1, 0] == pytest.approx(SPEED / fastest, rel=1e-4)
    assert np.all(active.numpy()[:, [0, 2]] > 0.0)
