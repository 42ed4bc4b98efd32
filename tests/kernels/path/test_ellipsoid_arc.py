"""Lengths of arcs on an ellipsoid, by quadrature and by chords in double precision."""

import numpy as np
import pytest
from probes import evaluate, units
from scipy.integrate import quad

from warpmuscle.kernels.path.ellipsoid_arc import arc_in_pieces, arc_on_ellipsoid

RADII = np.array([0.035, 0.02, 0.025])


def test_arcs_are_as_long_as_their_integrals():
    count = 60
    u = units(count, 5)
    v = np.cross(u, units(count, 6))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    angle = np.random.default_rng(7).uniform(0.05, 2.0, count)
    expected = [
        quad(lambda t, k=k: np.linalg.norm(RADII * (v[k] * np.cos(t) - u[k] * np.sin(t))), 0.0, angle[k])[0]
        for k in range(count)
    ]
    got = evaluate(arc_on_ellipsoid, u, v, angle, RADII)
    np.testing.assert_allclose(got, expected, rtol=2e-4)
    np.testing.assert_allclose(evaluate(arc_on_ellipsoid, u, v, angle, np.full(3, 0.03)), 0.03 * angle, rtol=1e-6)


def chords(radii: np.ndarray, u: np.ndarray, v: np.ndarray, middle: np.ndarray, angle: float, n: int) -> float:
    """Length of n chords by equal angles about the place where an axis of the ellipsoid meets the arc's plane."""
    fine = np.linspace(0.0, angle, 4001)
    points = (middle + np.outer(np.cos(fine), u) + np.outer(np.sin(fine), v)) * radii
    normal = np.cross(u * radii, v * radii)
    axis = int(np.argmax(np.abs(normal)))
    center = np.zeros(3)
    center[axis] = normal @ (middle * radii) / normal[axis]
    a, b = points[:-1] - center, points[1:] - center
    turns = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))
    turned = np.concatenate([[0.0], np.cumsum(turns)])
    ends = np.interp(np.linspace(0.0, turned[-1], n + 1), turned, fine)
    corners = (middle + np.outer(np.cos(ends), u) + np.outer(np.sin(ends), v)) * radii
    return float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())


@pytest.mark.parametrize(("size", "off"), [(0.2, 5e-7), (1.0, 1e-6)])
def test_pieces_cut_off_what_chords_do(size: float, off: float):
    """Of a finger's ellipsoid pieces of 1 mm cut off up to 16 um."""
    count, rng = 100, np.random.default_rng(8)
    normal = units(count, 9)
    shift = rng.uniform(0.0, 0.4, count)
    middle = normal * shift[:, None]
    u = np.cross(normal, units(count, 10))
    u *= (np.sqrt(1.0 - shift**2) / np.linalg.norm(u, axis=1))[:, None]
    v, angle, radii = np.cross(normal, u), rng.uniform(0.3, 1.5, count), size * RADII
    chord = (u * (np.cos(angle) - 1.0)[:, None] + v * np.sin(angle)[:, None]) * radii
    n = np.maximum(np.linalg.norm(chord, axis=1) / 1e-3, 1.0).astype(np.int32)
    right = np.array([chords(radii, *one) for one in zip(u, v, middle, angle, n, strict=True)])
    found = evaluate(arc_in_pieces, u, v, angle, middle, normal, np.repeat(radii[None], count, axis=0), n)
    whole = evaluate(arc_on_ellipsoid, u, v, angle, np.repeat(radii[None], count, axis=0))
    assert np.median(whole - right) > 10.0 * np.median(np.abs(found - right))
    assert np.quantile(np.abs(found - right), 0.95) < off
