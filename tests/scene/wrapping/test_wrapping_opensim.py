"""Paths round one surface as OpenSim 4.6 computes them, where it is installed."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from warpmuscle.scene import CylinderSurface, EllipsoidSurface, SphereSurface, Surface, TorusSurface
from warpmuscle.scene.wrapping.cylinder import AMONG_OTHERS, IN_PLANE
from warpmuscle.scene.wrapping.route import touch
from warpmuscle.scene.wrapping.touch import BESIDE

ZERO, COUNT = (0.0, 0.0, 0.0), 150
RADII = (0.035, 0.02, 0.025)


def cylinder(osim: Any) -> Any:
    made = osim.WrapCylinder()
    made.set_radius(0.03)
    made.set_length(0.2)
    return made


def sphere(osim: Any) -> Any:
    made = osim.WrapSphere()
    made.set_radius(0.03)
    return made


def ellipsoid(osim: Any) -> Any:
    made = osim.WrapEllipsoid()
    made.set_dimensions(osim.Vec3(*RADII))
    return made


def torus(osim: Any) -> Any:
    made = osim.WrapTorus()
    made.set_inner_radius(0.012)
    made.set_outer_radius(0.04)
    return made


def lengths(make: Callable[[Any], Any], ends: np.ndarray, quadrant: str, others: bool = False) -> np.ndarray:
    """OpenSim's lengths (n,) of a path between two points (n, 2, 3) on free bodies round a surface of the ground.

    Args:
        others: whether the path may go round another surface, too, which is too far away.
    """
    osim = pytest.importorskip("opensim")
    osim.Logger.setLevelString("Off")
    model = osim.Model()
    ground, surface, pull = model.updGround(), make(osim), osim.PathActuator()
    surface.setName("surface")
    surface.set_quadrant(quadrant)
    surface.setFrame(ground)
    ground.addWrapObject(surface)
    pull.setName("pull")
    for name in "ab":
        body = osim.Body(name, 1.0, osim.Vec3(0), osim.Inertia(1.0))
        joint = osim.FreeJoint(f"joint_{name}", ground, body)
        for axis in range(6):
            joint.upd_coordinates(axis).setName(f"{name}{axis}")
        model.addBody(body)
        model.addJoint(joint)
        pull.addNewPathPoint(name, body, osim.Vec3(0))
    model.addForce(pull)
    path = osim.GeometryPath.safeDownCast(pull.updPath())
    path.addPathWrap(surface)
    if others:
        far = sphere(osim)
        far.setName("far")
        far.set_translation(osim.Vec3(9.0))
        far.setFrame(ground)
        ground.addWrapObject(far)
        path.addPathWrap(far)
    state = model.initSystem()
    coordinates = [model.getCoordinateSet().get(f"{name}{axis}") for name in "ab" for axis in (3, 4, 5)]
    found = []
    for place in ends.reshape(len(ends), 6):
        for coordinate, value in zip(coordinates, place, strict=True):
            coordinate.setValue(state, float(value), False)
        model.realizePosition(state)
        found.append(path.getLength(state))
    return np.array(found)


def ours(surface: Surface, where: int, ends: np.ndarray) -> tuple[np.ndarray, int]:
    """Our lengths (n,) of the same, and how many of them touch."""
    found, touching = [], 0
    for a, b in ends:
        got = touch(surface, "hybrid", where, a, b)
        round_it = float(np.linalg.norm(got.first - a) + np.linalg.norm(got.second - b)) + got.length
        touching += got.kind >= BESIDE
        found.append(round_it if got.kind >= BESIDE else float(np.linalg.norm(b - a)))
    return np.array(found), touching


@pytest.mark.parametrize(
    ("make", "surface", "where", "within"),
    [
        (cylinder, CylinderSurface("b", ZERO, 0.03, 0.2), IN_PLANE, 1e-9),
        (cylinder, CylinderSurface("b", ZERO, 0.03, 0.2, side="+x"), IN_PLANE, 1e-9),
        (cylinder, CylinderSurface("b", ZERO, 0.03, 0.2, side="-y"), IN_PLANE, 1e-9),
        (cylinder, CylinderSurface("b", ZERO, 0.03, 0.2), AMONG_OTHERS, 1e-9),
        (cylinder, CylinderSurface("b", ZERO, 0.03, 0.2, side="+x"), AMONG_OTHERS, 1e-9),
        (cylinder, CylinderSurface("b", ZERO, 0.03, 0.2, side="-y"), AMONG_OTHERS, 1e-9),
        (sphere, SphereSurface("b", ZERO, 0.03), IN_PLANE, 1e-9),
        (sphere, SphereSurface("b", ZERO, 0.03, side="-z"), IN_PLANE, 1e-9),
        (ellipsoid, EllipsoidSurface("b", ZERO, RADII), IN_PLANE, 1e-7),
        (ellipsoid, EllipsoidSurface("b", ZERO, RADII, side="+x"), IN_PLANE, 1e-7),
        (torus, TorusSurface("b", ZERO, 0.012, 0.04), IN_PLANE, 1e-9),
        (torus, TorusSurface("b", ZERO, 0.012, 0.04, side="+x"), IN_PLANE, 1e-9),
        (torus, TorusSurface("b", ZERO, 0.012, 0.04), AMONG_OTHERS, 1e-9),
    ],
    ids=[
        "cylinder", "cylinder +x", "cylinder -y", "cylinder among others", "cylinder +x among others",
        "cylinder -y among others", "sphere", "sphere -z", "ellipsoid", "ellipsoid +x", "torus", "torus +x",
        "torus among others",
    ],
)  # fmt: skip
def test_paths_round_a_surface_are_as_long_as_opensims(make: Any, surface: Surface, where: int, within: float):
    ends = np.random.default_rng(3).normal(size=(COUNT, 2, 3), scale=0.05)
    expected = lengths(make, ends, surface.side or "all", where == AMONG_OTHERS)
    found, touching = ours(surface, where, ends)
    assert touching > 15
    known = np.isfinite(expected)  # round ellipsoids, OpenSim's are not always
    assert np.isfinite(found).all()
    assert known.mean() > 0.96
    np.testing.assert_allclose(found[known], expected[known], rtol=0.0, atol=within)
