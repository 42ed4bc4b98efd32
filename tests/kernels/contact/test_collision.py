"""Distances of segments against all candidates for the nearest points in float64."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from probes import evaluate, units, vectors

from warpmuscle.kernels.contact.collision import segment_distance_sq

N = 2000


def point_distance(point: np.ndarray, start: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Distances (n,) of points and segments (n, 3)."""
    square = np.sum(along * along, axis=-1)
    t = np.sum((point - start) * along, axis=-1) / np.where(square > 0.0, square, 1.0)
    return np.linalg.norm(point - start - np.clip(t, 0.0, 1.0)[:, None] * along, axis=-1)


def expected_distance(middle: np.ndarray, half_a: np.ndarray, half_b: np.ndarray) -> np.ndarray:
    """Least of the distances of the four ends from the other segment, and of the lines where their feet lie inside."""
    a, b, start_a, start_b = 2.0 * half_a, 2.0 * half_b, -half_a, middle - half_b
    ends = [point_distance(p, start_b, b) for p in (start_a, half_a)]
    ends += [point_distance(p, start_a, a) for p in (start_b, middle + half_b)]
    normal = np.cross(a, b)
    square = np.sum(normal * normal, axis=-1)
    safe = np.where(square > 0.0, square, 1.0)
    s = np.sum(np.cross(start_b - start_a, b) * normal, axis=-1) / safe
    t = np.sum(np.cross(start_b - start_a, a) * normal, axis=-1) / safe
    inside = (square > 0.0) & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    lines = np.abs(np.sum((start_b - start_a) * normal, axis=-1)) / np.sqrt(safe)
    return np.minimum(np.min(ends, axis=0), np.where(inside, lines, np.inf))


def assert_distances_agree(middle: np.ndarray, half_a: np.ndarray, half_b: np.ndarray) -> None:
    given_numbers = [np.asarray(v, dtype=np.float32).astype(float) for v in (middle, half_a, half_b)]
    found = np.sqrt(evaluate(segment_distance_sq, *given_numbers))
    size = sum(np.linalg.norm(v, axis=-1) for v in given_numbers)
    assert np.all(np.abs(found - expected_distance(*given_numbers)) <= 3e-6 * size + 1e-9)


def test_segments_of_any_size_and_place():
    for seed in range(5):
        lengths = np.random.default_rng(seed).choice([0.0, 1e-3, 0.1, 1.0], (2, N, 1))
        assert_distances_agree(
            vectors(N, seed, 0.5), units(N, seed + 10) * lengths[0], units(N, seed + 20) * lengths[1]
        )


def test_parallel_and_almost_parallel_segments():
    axis = units(N, 1)
    for angle in (0.0, 1e-7, 1e-5, 1e-4, 1e-3, 1e-2):
        for sign in (-1.0, 1.0):
            assert_distances_agree(vectors(N, 2, 0.3), axis, sign * (0.3 * axis + angle * units(N, 3)))


def test_segments_on_one_line():
    axis = units(N, 4)
    places = np.random.default_rng(5).uniform(-2.0, 2.0, (N, 1))
    assert_distances_agree(axis * places, axis * 0.4, axis * -0.3)


COMPONENT = st.sampled_from([0.0, 1e-12, 1e-4, 0.5, -0.5, 1.0]) | st.floats(-1.0, 1.0, width=32)
VECTOR = st.tuples(COMPONENT, COMPONENT, COMPONENT)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.tuples(VECTOR, VECTOR, VECTOR), min_size=30, max_size=60))
def test_segments_whose_coordinates_are_often_alike(segments: list):
    middle, half_a, half_b = np.array(segments).swapaxes(0, 1)
    assert_distances_agree(middle, half_a, half_b)
    swapped = evaluate(segment_distance_sq, -middle, half_b, half_a)
    np.testing.assert_allclose(
        np.sqrt(swapped), np.sqrt(evaluate(segment_distance_sq, middle, half_a, half_b)), atol=3e-6
    )
