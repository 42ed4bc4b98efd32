"""The nearest points of a segment and a box, against a search in float64."""

import numpy as np
import warp as wp
from probes import evaluate, vectors

from warpmuscle.kernels.objects import shape

COUNT = 300


def distance(point: np.ndarray, half: np.ndarray) -> np.ndarray:
    """From a box about the origin, m."""
    return np.linalg.norm(point - np.clip(point, -half, half), axis=-1)


def boxes() -> np.ndarray:
    """Half edges of boxes, of capsules' lines, and of points."""
    half = np.abs(vectors(COUNT, 3, 0.4))
    half[:100, [0, 2]] = 0.0
    half[100:200] = 0.0
    return half


def test_the_nearest_place_of_a_segment_is_where_a_fine_search_finds_it():
    middle, along, half = vectors(COUNT, 0), vectors(COUNT, 1, 0.5), boxes()
    t = evaluate(shape.nearest_on_segment, middle, along, half)
    found = distance(middle + t[:, None] * along, half)
    fine = np.linspace(-1.0, 1.0, 4001)[:, None, None]
    least = distance(middle + fine * along, half).min(axis=0)
    assert np.all(np.abs(t) <= 1.0)
    np.testing.assert_allclose(found, least, atol=5e-4)  # a slope below 0.001 counts as none


def test_a_segment_along_a_face_is_nearest_in_the_middle_of_what_lies_over_it():
    middle, along, half = np.array([0.5, 1.0, 0.0]), np.array([1.0, 0.0, 0.0]), np.array([1.0, 0.3, 0.3])
    t = evaluate(shape.nearest_on_segment, middle, along, half)  # which lies over the face from its start to 0.5
    np.testing.assert_allclose(t, -0.25, atol=2e-3)
    assert evaluate(shape.nearest_on_segment, np.zeros(3), np.zeros(3), np.ones(3)) == 0.0


@wp.kernel(enable_backward=False)
def ask(point: wp.array[wp.vec3], half: wp.array[wp.vec3], normal: wp.array[wp.vec3], on: wp.array[wp.vec4]):
    i = wp.tid()
    b = shape.between(point[i], half[i])
    normal[i] = b.normal
    on[i] = wp.vec4(b.on_box[0], b.on_box[1], b.on_box[2], b.distance)


def test_what_lies_between_a_box_and_a_point_outside_and_inside():
    point, half = vectors(COUNT, 5, 0.6), np.abs(vectors(COUNT, 6, 0.6)) + 0.05
    given = [wp.array(values.astype(np.float32), dtype=wp.vec3, device="cpu") for values in (point, half)]
    normal, on = wp.zeros(COUNT, dtype=wp.vec3, device="cpu"), wp.zeros(COUNT, dtype=wp.vec4, device="cpu")
    wp.launch(ask, COUNT, [*given, normal, on], device="cpu")
    outside = distance(point, half)
    deep = (half - np.abs(point)).min(axis=1)
    expected = np.where(outside > 0.0, outside, -deep)
    assert (outside > 0.0).sum() > 50
    assert (outside == 0.0).sum() > 20
    np.testing.assert_allclose(on.numpy()[:, 3], expected, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(normal.numpy(), axis=1), 1.0, atol=1e-6)
    far = distance(point + 0.01 * normal.numpy(), half)
    np.testing.assert_allclose(far[outside > 1e-3], outside[outside > 1e-3] + 0.01, atol=1e-5)


@wp.kernel(enable_backward=False)
def ask_on(point: wp.array[wp.vec3], half: wp.array[wp.vec3], face: wp.array[wp.vec3], on: wp.array[wp.vec4]):
    i = wp.tid()
    b = shape.between_on(point[i], half[i], face[i])
    on[i] = wp.vec4(b.on_box[0], b.on_box[1], b.on_box[2], b.distance)


def test_a_point_inside_is_as_deep_below_a_given_face_as_its_distance_from_it():
    half = np.abs(vectors(COUNT, 8, 0.6)) + 0.05
    point = vectors(COUNT, 9) * half
    inside = (np.abs(point) < half - 1e-5).all(axis=1)
    face, rows = np.zeros((COUNT, 3)), np.arange(COUNT)
    axis, sign = rows % 3, np.where(rows % 2, 1.0, -1.0)
    face[rows, axis] = sign
    given = [wp.array(values.astype(np.float32), dtype=wp.vec3, device="cpu") for values in (point, half, face)]
    on = wp.zeros(COUNT, dtype=wp.vec4, device="cpu")
    wp.launch(ask_on, COUNT, [*given, on], device="cpu")
    there = point.copy()
    there[rows, axis] = sign * half[rows, axis]
    deep = half[rows, axis] - sign * point[rows, axis]
    assert 20 < inside.sum() < COUNT
    np.testing.assert_allclose(on.numpy()[inside, :3], there[inside], atol=1e-6)
    np.testing.assert_allclose(on.numpy()[inside, 3], -deep[inside], atol=1e-6)
    outside = distance(point, half)
    np.testing.assert_allclose(on.numpy()[outside > 1e-5, 3], outside[outside > 1e-5], atol=1e-6)


def test_the_face_towards_another_object_is_that_out_of_which_it_has_least_far_to_go():
    half, reach, middle = np.abs(vectors(COUNT, 10)) + 0.1, np.abs(vectors(COUNT, 11)) + 0.1, vectors(COUNT, 12)
    found = evaluate(shape.least_overlap, middle, reach, half)
    ways = np.concatenate([np.eye(3), -np.eye(3)])
    far = half[:, None] @ np.abs(ways).T + reach[:, None] @ np.abs(ways).T - middle[:, None] @ ways.T
    np.testing.assert_array_equal(found, ways[far[:, 0].argmin(axis=1)])


def test_corners_of_a_ball_a_capsule_and_a_box_are_counted_once():
    numbers = np.arange(8)
    for half, count in (((0.0, 0.0, 0.0), 1), ((0.0, 0.1, 0.0), 2), ((0.1, 0.2, 0.0), 4), ((0.1, 0.2, 0.3), 8)):
        seen = [bool(evaluate(shape.is_another, np.array([k]), np.array(half))[0]) for k in numbers]
        assert sum(seen) == count
        places = evaluate(shape.corner, numbers, np.array(half))[seen]
        assert len({tuple(place) for place in places}) == count
        np.testing.assert_allclose(np.abs(places), np.broadcast_to(half, places.shape), rtol=1e-6)


def test_points_between_corners_lie_on_edges_and_faces():
    numbers = np.arange(shape.PARTS**3)
    for half, count in (((0.2, 0.1, 0.4), 90), ((0.0, 0.3, 0.0), 23), ((0.0, 0.0, 0.0), 0)):
        each = np.tile(half, (len(numbers), 1))
        used = evaluate(shape.is_between, numbers, each).astype(bool)
        places = evaluate(shape.part_of, numbers, each)[used]
        assert used.sum() == count == len(np.unique(places.round(6), axis=0))
        assert np.all(np.abs(places) <= np.array(half) + 1e-7)
        if half[0] > 0.0:
            at_ends = np.isclose(np.abs(places), half)
            assert np.all((at_ends.sum(axis=1) == 1) | (at_ends.sum(axis=1) == 2))


def test_a_segment_is_within_a_box_where_points_of_it_are():
    middle, along, half = vectors(COUNT, 4, 0.3), vectors(COUNT, 5, 0.6), np.abs(vectors(COUNT, 6, 0.4)) + 0.05
    found = evaluate(shape.within, middle, along, half)
    t = np.linspace(-1.0, 1.0, 2001)
    inside = np.all(np.abs(middle[:, None] + along[:, None] * t[:, None]) < half[:, None], axis=2)
    expected = (found[:, :1] < t) & (t < found[:, 1:])
    near = np.abs(t - found[:, :1]) < 1e-5
    near |= np.abs(t - found[:, 1:]) < 1e-5
    assert np.all((inside == expected) | near)
    assert 20 < np.any(inside, axis=1).sum() < COUNT - 20


def test_middles_of_edges_are_those_of_a_box():
    half = np.array([0.2, 0.1, 0.4])
    found = evaluate(shape.edge_middle, np.arange(12), np.tile(half, (12, 1))).reshape(3, 4, 3)
    for axis in range(3):
        sides = np.round(np.delete(found[axis] / half, axis, axis=1), 6)
        assert np.all(found[axis][:, axis] == 0.0)
        assert sorted(sides.tolist()) == [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]]
