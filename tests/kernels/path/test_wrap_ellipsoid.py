"""Parts of a path round an ellipsoid, in closed form or by what they must fulfil."""

import numpy as np
import pytest
import warp as wp
from probes import evaluate, units, vectors

from warpmuscle.kernels.path import wrap_ellipsoid
from warpmuscle.kernels.path.wrap_ellipsoid import AXIAL, HYBRID, MIDPOINT, Guide
from warpmuscle.kernels.path.wrap_touch import BESIDE, FREE, Touch
from warpmuscle.scene.wrapping import ellipsoid as on_host

RADII = np.array([0.035, 0.02, 0.025])
METHODS = {"hybrid": HYBRID, "midpoint": MIDPOINT, "axial": AXIAL}

guide = wrap_ellipsoid.guide_of(False)


@wp.kernel(enable_backward=False)
def guides(start: wp.array[wp.vec3], chord: wp.array[wp.vec3], r: wp.vec3, method: int, result: wp.array[Guide]):
    i = wp.tid()
    result[i] = guide(start[i], chord[i], r, method)


@wp.kernel(enable_backward=False)
def touches(
    a: wp.array[wp.vec3], b: wp.array[wp.vec3], r: wp.vec3, axis: int, side: int, method: int, result: wp.array[Touch]
):
    i = wp.tid()
    result[i] = wrap_ellipsoid.ellipsoid_touch(a[i], b[i], r, axis, side, method)


def launched(kernel, struct, a: np.ndarray, b: np.ndarray, radii: np.ndarray, *more: int) -> np.ndarray:
    given = [wp.array(np.float32(v), dtype=wp.vec3, device="cpu") for v in (a, b)]
    result = wp.zeros(len(a), dtype=struct, device="cpu")
    wp.launch(kernel, len(a), [*given, wp.vec3(*radii.tolist()), *more, result], device="cpu")
    return result.numpy()


def test_of_two_tangents_to_a_circle_the_outward_one_is_taken():
    """Both ends of the chord of contact: from m, v r^2/|v|^2 +- n x v r sqrt(|v|^2 - r^2)/|v|^2."""
    count, rng = 400, np.random.default_rng(0)
    normal, middle = units(count, 1), vectors(count, 2, 0.3)
    v = np.cross(normal, vectors(count, 3))
    v *= (rng.uniform(1.01, 4.0, count) / np.linalg.norm(v, axis=1))[:, None]
    outward = np.cross(normal, vectors(count, 4, 0.2))
    radius = rng.uniform(0.2, 1.0, count)
    far, across = np.sum(v * v, axis=1), np.cross(normal, v)
    leg = radius * np.sqrt(far - radius**2)
    both = [middle + (v * radius[:, None] ** 2 + sign * across * leg[:, None]) / far[:, None] for sign in (1.0, -1.0)]
    ahead = np.sum((both[0] - both[1]) * outward, axis=1)
    expected = np.where(ahead[:, None] > 0.0, *both)
    got = evaluate(wrap_ellipsoid.circle_tangent, middle + v, middle, normal, radius**2, outward)
    clear = np.abs(ahead) > 1e-3
    assert clear.sum() > 380
    np.testing.assert_allclose(got[clear], expected[clear], atol=2e-5)
    np.testing.assert_allclose(np.linalg.norm(got - middle, axis=1), radius, atol=2e-5)


def test_an_end_on_the_circle_is_its_own_tangent():
    end, (_, y, z) = np.array([[0.5, 0.0, 0.0], [0.3, 0.0, 0.0]]), np.eye(3)
    got = evaluate(wrap_ellipsoid.circle_tangent, end, np.zeros(3), z, 0.25, y)
    np.testing.assert_allclose(got, end, atol=1e-7)


def test_the_nearest_place_is_on_the_ellipsoid_and_its_normal_leads_there():
    place = vectors(300, 8, 0.04)
    place = place[np.abs(place).min(axis=1) > 2e-3]
    got = evaluate(wrap_ellipsoid.nearest_on_ellipsoid, place, RADII, -1)
    np.testing.assert_allclose(np.sum((got / RADII) ** 2, axis=1), 1.0, atol=2e-3)
    normal, away = got / RADII**2, place - got
    sine = np.linalg.norm(np.cross(normal, away), axis=1) / np.linalg.norm(normal, axis=1)
    assert np.quantile(sine, 0.98) < 2e-5
    others = np.linalg.norm(place[:40, None] - units(10000, 9) * RADII, axis=2).min(axis=1)
    assert np.all(np.linalg.norm(away[:40], axis=1) < others + 1e-5)


@pytest.mark.parametrize("across", [-1, 0, 1, 2])
def test_where_the_search_for_the_nearest_place_begins_does_not_matter(across: int):
    """Of places inside and outside, from far below to far above what it looks for."""
    place, radii = vectors(400, 11, 1.5), np.array([0.9, 0.6, 1.5])
    usual = evaluate(wrap_ellipsoid.nearest_multiplier, place, radii, across, -1e30)
    flat = np.delete((radii * place / (usual[:, None] + radii**2)), across, axis=1) if across >= 0 else (
        radii * place / (usual[:, None] + radii**2)
    )  # fmt: skip
    np.testing.assert_allclose(np.sum(flat**2, axis=1), 1.0, atol=2e-5)
    for guess in (-1.0, 0.0, 0.3, 5.0):
        np.testing.assert_allclose(
            evaluate(wrap_ellipsoid.nearest_multiplier, place, radii, across, guess), usual, atol=2e-5
        )


def mean_direction(start: np.ndarray, chord: np.ndarray, radii: np.ndarray, places: int = 2000) -> np.ndarray:
    """From places on chords to the nearest points of an ellipsoid, by Newton's method on the sum of squares."""
    square = radii**2
    p = start[:, None] + chord[:, None] * ((np.arange(places) + 0.5) / places)[:, None]
    t = np.max(radii * np.abs(p) - square, axis=-1, keepdims=True)
    for _ in range(60):
        x = (radii * p / (t + square)) ** 2
        t = t + (np.sum(x, axis=-1, keepdims=True) - 1.0) / np.sum(2.0 * x / (t + square), axis=-1, keepdims=True)
    away = p / (t + square)
    mean = np.mean(away / np.linalg.norm(away, axis=-1, keepdims=True), axis=1)
    return mean / np.linalg.norm(mean, axis=-1, keepdims=True)


@pytest.mark.parametrize("radii", [(0.9, 0.6, 1.5), (0.98, 1.39, 0.63), (0.6, 1.8, 0.6), (0.83, 0.83, 1.34)])
def test_the_fan_points_in_the_mean_direction_of_many_places(radii: tuple[float, ...]):
    """Flat, long and round ellipsoids; near an axis or plane where the direction jumps, a few are farther off."""
    count, r = 200, np.array(radii)
    first, second = r * units(count, 20), r * units(count, 21)
    start, chord = first, second - first
    toward = mean_direction(start, chord, r)
    point = evaluate(wrap_ellipsoid.nearest_on_ellipsoid, start + 0.5 * chord + toward, r, -1)
    for fan, median in ((wrap_ellipsoid.fan_by_gauss, 3e-4), (wrap_ellipsoid.fan_of_samples, 4e-3)):
        total = evaluate(fan, start, chord, r)
        mean = total / np.linalg.norm(total, axis=1, keepdims=True)
        got = evaluate(wrap_ellipsoid.nearest_on_ellipsoid, start + 0.5 * chord + mean, r, -1)
        off = np.linalg.norm(got - point, axis=1)
        assert np.all(np.quantile(off, [0.5, 0.9, 0.98]) < [median, 5e-3, 2e-2])


def test_the_mean_over_opensims_places_leaves_out_both_ends_and_one_more():
    """298 of 300 equal parts of the chord, so that it is off the mean by half and one and a half part's directions."""
    start, chord, r = np.array([[0.3, 0.5, -0.2]]), np.array([[0.2, -0.1, 0.4]]), np.array([0.9, 0.8, 1.5])
    places = start + chord * (np.arange(1, 299)[:, None] / 300.0)
    multipliers = evaluate(wrap_ellipsoid.nearest_multiplier, places, r, -1, -1e30)
    directions = evaluate(wrap_ellipsoid.outward_at_nearest, places, r, multipliers)
    got = evaluate(wrap_ellipsoid.fan_of_samples, start, chord, r)
    np.testing.assert_allclose(got[0], directions.sum(axis=0), atol=1e-3)


def test_a_chord_is_cut_where_it_crosses_the_plane_of_two_longer_axes_or_passes_the_longest_one():
    start, chord = np.array([[-0.3, 0.1, -0.2], [0.2, -0.1, -0.4]]), np.array([[0.6, 0.1, 0.8], [0.1, 0.3, 0.5]])
    flat, long = np.array([1.2, 1.2, 0.6]), np.array([0.7, 0.7, 1.6])
    got = evaluate(wrap_ellipsoid.turning_place, start, chord, flat)
    np.testing.assert_allclose(got, [0.25, 0.8], atol=1e-6)
    got = evaluate(wrap_ellipsoid.turning_place, start, chord, long)
    across = -np.sum(start[:, :2] * chord[:, :2], axis=1) / np.sum(chord[:, :2] ** 2, axis=1)
    np.testing.assert_allclose(got, np.clip(across, 0.0, 1.0), atol=1e-6)
    assert evaluate(wrap_ellipsoid.turning_place, start, chord, np.ones(3)) == pytest.approx(0.0)


def test_the_mean_direction_counts_where_a_chord_is_along_no_axis():
    """All where its greatest direction cosine is below 0.7073, not at all above 0.9, in proportion between."""
    cosine = np.array([0.58, 0.65, 0.70, 0.75, 0.80, 0.8537, 0.89, 0.95, 1.0])
    other = np.sqrt((1.0 - cosine**2) / 2.0)
    chord, radii = 0.8 * np.stack([other, cosine, -other], axis=1), RADII / RADII.mean()
    guide = launched(guides, Guide, -0.5 * chord + [0.1, 0.05, 0.2], chord, radii, HYBRID)
    expected = np.clip((0.9 - cosine) / (0.9 - 0.7073), 0.0, 1.0)
    np.testing.assert_allclose(guide["fan"], expected, atol=1e-5)
    np.testing.assert_allclose(np.sum((guide["point"] / radii) ** 2, axis=1), 1.0, atol=5e-3)


@pytest.mark.parametrize(("method", "axis"), [("midpoint", 0), ("midpoint", 2), ("axial", 0)])
def test_a_path_that_may_not_stay_on_its_side_goes_round_the_other_one(method: str, axis: int):
    """Of a chord along no axis: in the plane through the ends and the place opposite on a ball."""
    count, radius, rng = 4000, 0.03, np.random.default_rng(10)
    way = np.array([1.0, 1.1, 0.9]) * rng.choice([-1.0, 1.0], (count, 3)) * rng.uniform(0.95, 1.05, (count, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    middle = vectors(count, 11, 0.006)
    a, b = middle - 0.06 * way, middle + 0.07 * way
    side = 1
    guide = launched(guides, Guide, *chord_in_ball(a, b, radius), np.full(3, radius), METHODS[method])
    assert guide["fan"].max() == 0.0
    touch = launched(touches, Touch, a, b, np.full(3, radius), axis, side, METHODS[method])
    place = guide["point"].astype(float)
    wrong = (touch["kind"] >= BESIDE) & (place[:, axis] * side < -2e-3)
    place[:, axis] *= -1.0
    normal = np.cross(b - a, place - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    clear = wrong & (np.linalg.norm(np.cross(b - a, place - a), axis=1) > 2e-4)
    assert clear.sum() > 300
    for name in ("first", "second"):
        off = np.abs(np.sum((touch[name] - a) * normal, axis=1))
        assert np.quantile(off[clear], 0.98) < 2e-4, name


def chord_in_ball(a: np.ndarray, b: np.ndarray, radius: float) -> tuple[np.ndarray, np.ndarray]:
    """Where segments go into a ball, and the part of them that is inside."""
    d = b - a
    t = -np.sum(a * d, axis=1) / np.sum(d * d, axis=1)
    near = a + t[:, None] * d
    half = np.sqrt(radius**2 - np.sum(near * near, axis=1)) / np.linalg.norm(d, axis=1)
    return near - half[:, None] * d, 2.0 * half[:, None] * d


def test_round_a_ball_every_path_is_the_shortest_one_also_from_close_by():
    """Tangents sqrt(|a|^2 - R^2) and an arc R (angle - acos(R/|a|) - acos(R/|b|)), where a segment runs through."""
    count, radius, rng = 3000, 0.03, np.random.default_rng(12)
    near, far = radius * (1.0 + 10.0 ** rng.uniform(-2.5, 0.3, (2, count)))
    a, b = units(count, 13) * near[:, None], units(count, 14) * far[:, None]
    angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.sum(a * b, axis=1))
    arc = angle - np.arccos(radius / near) - np.arccos(radius / far)
    touch = launched(touches, Touch, a, b, np.full(3, radius), 0, 0, MIDPOINT)
    assert np.all(touch["kind"][arc > 0.02] >= BESIDE)
    assert np.all(touch["kind"][arc < -0.02] == FREE)
    length = np.linalg.norm(touch["first"] - a, axis=1) + np.linalg.norm(touch["second"] - b, axis=1) + touch["arc"]
    expected = np.sqrt(near**2 - radius**2) + np.sqrt(far**2 - radius**2) + radius * arc
    clear = (arc > 0.02) & (angle < 3.0)  # nearly opposite, the plane is anyone's
    assert clear.sum() > 1000
    np.testing.assert_allclose(length[clear], expected[clear], atol=2e-5)


@pytest.mark.parametrize("method", METHODS)
def test_a_segment_that_only_touches_runs_straight(method: str):
    """Along each axis beside each of the others, at exactly the radius: no part of it is within."""
    along = 0.06 * np.eye(3)[[0, 0, 1, 1, 2, 2]]
    beside = np.diag(RADII)[[1, 2, 0, 2, 0, 1]]
    a, b = beside + along, beside - along
    got = launched(touches, Touch, a, b, RADII, 0, 0, METHODS[method])
    assert got["kind"].tolist() == [FREE] * 6
    with np.errstate(all="raise"):
        kinds = [on_host.ellipsoid_touch(*ends, RADII, 0, 0, method).kind for ends in zip(a, b, strict=True)]
    assert kinds == [FREE] * 6
