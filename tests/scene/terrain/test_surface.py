"""The ground of a numeric scene as a surface, and as a mesh."""

import numpy as np
import pytest

from warpmuscle.scene import Ground, Terrain
from warpmuscle.scene.ground import plane
from warpmuscle.scene.terrain.mesh import in_world, mesh_of
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.terrain.tiles import Flat, Rough, Slope, Stairs

RNG = np.random.default_rng(0)
PLACES = RNG.uniform(-3.0, 3.0, (400, 3))
INCLINED = {"normal": (0.1, 2.0, -0.3), "height": 0.4}


@pytest.mark.parametrize("terrain", [None, Terrain([Flat()], yaw=0.4), Terrain([Rough()], scale=0.0)])
def test_ground_without_heights_is_its_plane(terrain: Terrain | None):
    flat, found = plane(Ground(**INCLINED)), surface(Ground(**INCLINED, terrain=terrain))
    x, _, z = PLACES.T
    np.testing.assert_allclose(found.height_at(x, z), flat.height_at(x, z), atol=1e-12)
    np.testing.assert_allclose(found.normal_at(x, z), np.broadcast_to(flat.normal, (400, 3)), atol=1e-12)
    np.testing.assert_allclose(found.above(PLACES), PLACES @ flat.normal - flat.height, atol=1e-12)


def test_a_tile_rises_to_where_it_is_turned():
    """Turned to the left by a quarter, what rose forwards rises to the left, which is x."""
    turned = surface(Ground(terrain=Terrain([Slope(0.2)], yaw=0.5 * np.pi, x=1.0)))
    assert turned.height_at(3.0, 5.0) == pytest.approx(2.0 * np.tan(0.2))
    np.testing.assert_allclose(turned.normal_at(0.0, 0.0), [-np.sin(0.2), np.cos(0.2), 0.0], atol=1e-12)


def test_distances_from_a_slope_are_those_from_its_plane():
    found = surface(Ground(**INCLINED, terrain=Terrain([Slope(0.3)], yaw=0.7, x=0.2, z=0.5)))
    origin = np.array([0.0, float(found.height_at(0.0, 0.0)), 0.0])
    normal = found.normal_at(0.0, 0.0)
    np.testing.assert_allclose(found.above(PLACES), (PLACES - origin) @ normal, atol=1e-12)


def test_numbers_of_several_instances_are_those_of_the_first():
    several = Terrain([Flat(), Slope(0.1)], tile=np.array([1.0, 0.0]), z=np.array([1.0, 5.0]))
    assert surface(Ground(terrain=several)).height_at(0.0, 2.0) == pytest.approx(np.tan(0.1))


def test_the_highest_ground_about_a_place_is_found():
    found = surface(Ground(terrain=Terrain([Stairs(0.2, start=1.0, count=1)])))
    assert found.highest_rise(0.0, 0.8, 0.25) == pytest.approx(0.2)
    assert found.highest_rise(0.0, 0.5, 0.25) == 0.0


@pytest.mark.parametrize("longest", [np.inf, 0.5])
def test_a_mesh_lies_on_the_ground_and_has_the_lines_of_its_edges(longest: float):
    ground = surface(Ground(**INCLINED, terrain=Terrain([Stairs(0.2, count=3)], yaw=0.3, z=0.2)))
    assert ground.lie is not None
    mesh = mesh_of(ground.lie, np.array([-2.0, -1.0]), np.array([2.0, 4.0]), longest=longest)
    points = in_world(ground.lie, mesh, ground)
    np.testing.assert_allclose(points[..., 1], ground.height_at(points[..., 0], points[..., 2]), atol=1e-9)
    assert np.isclose(mesh.z[:, None], [1.0, 1.29, 1.58]).any(axis=0).all()
    assert max(np.diff(mesh.x).max(), np.diff(mesh.z).max()) <= longest + 1e-9


def test_a_mesh_of_much_ground_has_no_more_lines_than_it_may():
    ground = surface(Ground(terrain=Terrain([Rough(spacing=0.01)])))
    assert ground.lie is not None
    mesh = mesh_of(ground.lie, np.full(2, -500.0), np.full(2, 500.0), most=50)
    assert mesh.rise.shape[0] <= 50
    assert mesh.rise.shape[1] <= 50
