"""Symmetric blocks, shifts and rotations against dense algebra in float64."""

import numpy as np
from probes import cross_matrix, evaluate, matrix, turn_about, units, vectors

from biped import multiply, rotate
from warpmuscle.kernels.algebra import spatial

N = 100
ROWS, COLUMNS = np.triu_indices(3)


def packed(dense: np.ndarray) -> np.ndarray:
    """Upper halves (n, 6) of matrices (n, 3, 3): xx, xy, xz, yy, yz, zz."""
    return dense[..., ROWS, COLUMNS]


def matrices(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(N, 3, 3))


def symmetrics(seed: int) -> np.ndarray:
    """Positive definite matrices."""
    a = matrices(seed)
    return a @ a.swapaxes(1, 2) + 0.5 * np.eye(3)


def close(got: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(got, expected, atol=3e-6 * np.abs(expected).max())


def test_six_numbers_are_the_matrix_and_back():
    s, m = symmetrics(1), matrices(2)
    close(evaluate(spatial.full, packed(s)), s)
    close(evaluate(spatial.symmetric_part, m), packed(0.5 * (m + m.swapaxes(1, 2))))


def test_symmetric_matrix_times_vector():
    s, v = symmetrics(1), vectors(N)
    close(evaluate(spatial.symmetric_times, packed(s), v), np.einsum("nij,nj->ni", s, v))


def test_outer_product():
    v = vectors(N)
    close(evaluate(spatial.symmetric_outer, v, -1.7), -1.7 * packed(v[:, :, None] * v[:, None, :]))


def test_inverse_times_matrix_is_one():
    s = symmetrics(1)
    inverse = evaluate(spatial.full, evaluate(spatial.symmetric_inverse, packed(s)))
    np.testing.assert_allclose(inverse @ s, np.broadcast_to(np.eye(3), (N, 3, 3)), atol=1e-4)


def test_rotated_tensor():
    r, d = matrix(units(N, 1, 4)), np.abs(vectors(N, 2))
    close(evaluate(spatial.symmetric_rotated, r, d), packed(r @ (d[:, :, None] * np.eye(3)) @ r.swapaxes(1, 2)))


def test_product_that_is_symmetric():
    a, s = matrices(1), symmetrics(2)
    b = s @ a.swapaxes(1, 2)
    close(evaluate(spatial.symmetric_product, a, b), packed(a @ b))


def test_cross_product_with_every_column():
    r, s = vectors(N), symmetrics(1)
    close(evaluate(spatial.cross_rows, r, packed(s)), cross_matrix(r) @ s)


def test_shift_of_an_inertia_is_the_congruence_of_its_six_by_six_matrix():
    """With X = [[1, [r]x], [0, 1]], a shifted inertia is X [[A, B], [B^T, C]] X^T."""
    r, a, b, c = vectors(N), symmetrics(1), matrices(2), symmetrics(3)
    one, zero = np.broadcast_to(np.eye(3), (N, 3, 3)), np.zeros((N, 3, 3))
    x = np.block([[one, cross_matrix(r)], [zero, one]])
    shifted = x @ np.block([[a, b], [b.swapaxes(1, 2), c]]) @ x.swapaxes(1, 2)
    block_b = b + evaluate(spatial.cross_rows, r, packed(c))
    close(block_b, shifted[:, :3, 3:])
    close(packed(a) + evaluate(spatial.shifted_angular, b, block_b, r), packed(shifted[:, :3, :3]))


def test_turn_is_the_exponential_of_a_constant_angular_velocity():
    q, w, h = units(N, 1, 4), vectors(N, 2, 10.0), 0.0005
    speed = np.linalg.norm(w, axis=1)
    exact = multiply(q, turn_about(w / speed[:, None], h * speed))
    np.testing.assert_allclose(evaluate(spatial.turn, q, w, h), exact, atol=3e-7)


def test_turn_is_of_third_order():
    """Errors of single steps at 50 rad/s and 1/500 s stay below the fourth power of the angle."""
    q, axis = units(N, 1, 4), units(N, 2)
    exact = multiply(q, turn_about(axis, np.full(N, 0.1)))
    np.testing.assert_allclose(evaluate(spatial.turn, q, 50.0 * axis, 0.002), exact, atol=0.05**4 + 2e-7)


def test_turn_keeps_unit_length():
    length = np.linalg.norm(evaluate(spatial.turn, units(N, 1, 4), vectors(N, 2, 300.0), 0.002), axis=1)
    np.testing.assert_allclose(length, 1.0, atol=3e-7)


def test_heading_leaves_a_turn_about_a_horizontal_axis():
    q = units(N, 1, 4)
    heading = evaluate(spatial.heading, q)
    np.testing.assert_allclose(heading[:, [0, 2]], 0.0)
    rest = multiply(heading * [-1.0, -1.0, -1.0, 1.0], q)
    np.testing.assert_allclose(rest[:, 1], 0.0, atol=1e-6)


def test_heading_of_a_turn_about_the_vertical_is_that_turn():
    angle = np.linspace(-3.1, 3.1, 63)
    q = turn_about(np.array([0.0, 1.0, 0.0]), angle)
    np.testing.assert_allclose(evaluate(spatial.heading, q), q, atol=1e-6)
    for sign in (1.0, -1.0):
        np.testing.assert_allclose(evaluate(spatial.heading_angle, sign * q), angle, atol=1e-6)


def test_heading_of_an_upside_down_body_is_none():
    np.testing.assert_allclose(evaluate(spatial.heading, np.array([[1.0, 0.0, 0.0, 0.0]])), [[0.0, 0.0, 0.0, 1.0]])


def test_rotation_matrices_of_these_tests_rotate():
    q, v = units(N, 1, 4), vectors(N)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", matrix(q), v), rotate(q, v), atol=1e-12)
    np.testing.assert_allclose(np.einsum("nij,nj->ni", cross_matrix(v), q[:, :3]), np.cross(v, q[:, :3]), atol=1e-12)


def test_heading_is_the_twist_about_the_vertical():
    """Of q = heading r, r turns about a horizontal axis: it has no part about y, and the heading no other."""
    q = units(N, 3, 4)
    found = evaluate(spatial.heading, q)
    norm = np.hypot(q[:, 1], q[:, 3])
    np.testing.assert_allclose(found[:, [1, 3]], q[:, [1, 3]] / norm[:, None], atol=3e-7)
    assert not found[:, [0, 2]].any()
    rest = multiply(found * [-1.0, -1.0, -1.0, 1.0], q)
    np.testing.assert_allclose(rest[:, 1], 0.0, atol=3e-7)


def test_heading_of_what_lies_upside_down_is_none():
    np.testing.assert_array_equal(evaluate(spatial.heading, np.array([[0.6, 0.0, 0.8, 0.0]])), [[0.0, 0.0, 0.0, 1.0]])
