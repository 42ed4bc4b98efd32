"""Polynomials fitted to the paths of muscles: they have their lengths and nearly their moment arms."""

import numpy as np
import pytest

from muscle_arm import arm, leg
from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load, save
from warpmuscle.scene import CylinderSurface, Joint, Scene, Wrap
from warpmuscle.simulation.stages import MusclePaths, Stages
from warpmuscle.studies.fit_paths import _fitted, fit_paths

X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def test_polynomials_are_fitted_to_two_thirds_of_the_poses_and_judged_by_the_rest():
    q = np.random.default_rng(1).uniform(-1.0, 1.0, (90, 1))
    length = 0.3 + 0.05 * q
    length[60:] += 0.004
    polynomial, fit = _fitted("one", [("knee", 0)], q, length[:, 0], 1e-3, 1)
    assert (fit.muscle, fit.order, fit.terms) == ("one", 1, 2)
    assert (fit.rms, fit.worst) == pytest.approx((0.004, 0.004))
    assert polynomial.coefficients == pytest.approx([0.3, 0.05])


def wrapped_leg() -> Scene:
    """The leg with a universal joint as hip, and a muscle around a cylinder at the knee."""
    scene = leg()
    character = scene.character
    character.joints["hip"] = Joint("universal", "pelvis", "thigh", (0.0, -0.05, 0.0), (0.0, 0.2, 0.0), [X, Z])
    character.joints["hip"].limits = [(-0.5, 0.8), (-0.3, 0.3)]
    character.joints["knee"].limits = [(-0.2, 1.2)]
    character.surfaces["knee"] = CylinderSurface("thigh", (0.0, -0.2, 0.0), 0.045, 0.2, (0.0, np.pi / 2, 0.0), "-x")
    character.muscles["knee"].wraps = [Wrap("knee")]
    return scene


def paths(scene: Scene, count: int = 400) -> MusclePaths:
    """Paths in random poses within the limits."""
    stages, rng = Stages(scene, count, "cpu"), np.random.default_rng(9)
    q = stages.state.coordinates.numpy().copy()
    q[:, 7:] = rng.uniform([-0.5, -0.3, -0.2], [0.8, 0.3, 1.2], (count, 3))
    stages.state.coordinates.assign(q.astype(np.float32))
    return stages.muscle_paths()


@pytest.mark.usefixtures("unoptimized_test")
def test_fitted_polynomials_have_the_lengths_and_moment_arms_of_the_paths():
    scene = wrapped_leg()
    fitted, fits = fit_paths(scene)
    assert [fit.muscle for fit in fits] == list(scene.character.muscles)
    assert all(fit.rms < 1e-4 for fit in fits)
    assert all(not muscle.path and not muscle.wraps for muscle in fitted.character.muscles.values())
    before, after = paths(scene), paths(fitted)
    assert np.sqrt(np.mean((before.length - after.length) ** 2, axis=0)).max() < 1.2e-4
    assert (before.muscle, before.joint) == (after.muscle, after.joint)
    assert np.sqrt(np.mean((before.moment_arm[..., 0] - after.moment_arm[..., 0]) ** 2)) < 2e-3


def test_the_order_is_the_smallest_that_fits_and_else_the_best():
    fits = [fit_paths(wrapped_leg(), rms, 6)[1] for rms in (1e-3, 1e-4, 1e-9)]
    orders = np.array([[fit.order for fit in of_rms] for of_rms in fits])
    assert np.all(np.diff(orders, axis=0) >= 0)
    assert orders[0].max() < orders[2].max()
    assert all(fit.rms > 1e-9 for fit in fits[2])


def test_the_fitted_scene_is_written_and_read(tmp_path):
    fitted, _ = fit_paths(wrapped_leg(), 1e-3)
    save(fitted, tmp_path / "fitted.toml")
    assert load(tmp_path / "fitted.toml") == fitted


def test_a_ball_joint_has_no_coordinates_for_polynomials():
    with pytest.raises(SceneError, match="acts on the ball joint 'hip'") as error:
        fit_paths(leg())
    assert error.value.key == "character.muscles.both"


def test_an_order_that_no_polynomial_may_have_is_refused():
    with pytest.raises(SceneError, match="within 1 and 20, is 21"):
        fit_paths(arm(), order=21)
