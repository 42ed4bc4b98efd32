"""Whether a mesh of the viewer is closed and looks outwards."""

import numpy as np

from warpmuscle.view.hulls import Mesh


def volume(mesh: Mesh) -> float:
    corners, _, faces = mesh
    a, b, c = (corners[faces[:, k]] for k in range(3))
    return float(np.sum(a * np.cross(b, c)) / 6.0)


def check(corners: np.ndarray, normals: np.ndarray, faces: np.ndarray) -> None:
    assert np.isfinite(corners).all()
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
    a, b, c = (corners[faces[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    seen = np.sum(area * normals[faces].mean(axis=1), axis=1)
    assert (seen > -1e-9).mean() > 0.98  # counter-clockwise from outside, but for a few in sharp bends
