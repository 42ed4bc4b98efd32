"""What a page is sent of ground that is not flat."""

from types import SimpleNamespace

import numpy as np

from warpmuscle.scene import Body, Character, Ground, Scene, Terrain
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.terrain.tiles import Rough, Stairs
from warpmuscle.view.page import ground_content
from warpmuscle.view.terrain.content import terrain_content

STAIRS = Ground(terrain=Terrain([Stairs(0.2, count=3)], z=0.5))


def on(ground: Ground) -> Scene:
    return Scene("block", Character("block", {"block": Body(1.0, (1.0, 1.0, 1.0))}), ground=ground)


def walk(length: float) -> SimpleNamespace:
    z = np.linspace(0.0, length, 50)
    return SimpleNamespace(com=np.stack([0.0 * z, 1.0 + 0.0 * z, z], axis=1))


def points_of(mesh) -> np.ndarray:
    return np.reshape(mesh["points"], (*mesh["shape"], 3))


def test_flat_ground_has_no_mesh_and_a_mesh_reaches_beyond_a_walk():
    assert ground_content(on(Ground()))["terrain"] == []
    (mesh,) = terrain_content([STAIRS], [walk(6.0)])
    points = points_of(mesh)
    assert points[0, 0, 2] <= -12.0
    assert points[-1, 0, 2] >= 18.0
    truth = surface(STAIRS).height_at(points[..., 0], points[..., 2])
    assert np.abs(points[..., 1] - truth).max() < 0.01  # rounded places on steep risers


def test_each_of_several_bipeds_has_its_own_ground_in_its_lane():
    grounds = [STAIRS, Ground(), Ground(terrain=Terrain([Rough()]))]
    offsets = [np.array([1.3 * k, 0.0, 0.0]) for k in range(3)]
    first, second = terrain_content(grounds, [walk(3.0)] * 3, offsets, 1.3)
    assert (first["offset"], second["offset"]) == ([0.0, 0.0, 0.0], [2.6, 0.0, 0.0])
    assert np.ptp(points_of(first)[..., 0]) == np.float64(1.3)


def test_where_a_biped_will_go_is_not_known_live():
    points = points_of(ground_content(on(STAIRS))["terrain"][0])
    assert points[..., 2].max() >= 24.0
