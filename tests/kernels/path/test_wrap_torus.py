"""Where a line is nearest to the circle within a torus: against MINPACK, whose search OpenSim's path follows."""

import numpy as np
import pytest
from probes import evaluate
from scipy.optimize import leastsq

from warpmuscle.kernels.path import wrap_torus
from warpmuscle.kernels.path.wrap_cylinder import IN_PLANE
from warpmuscle.kernels.path.wrap_touch import BESIDE
from warpmuscle.scene import TorusSurface
from warpmuscle.scene.wrapping import torus
from warpmuscle.scene.wrapping.route import touch


class Line:
    """A line from a to b beside a circle about z, by the distance u along it from a; in float64."""

    def __init__(self, a: np.ndarray, b: np.ndarray, ring: float) -> None:
        self.a, self.n, self.ring = a, (b - a) / np.linalg.norm(b - a), ring

    def excess(self, u: float) -> float:
        """Twice the place along the line, less 4 R times how fast it moves away from the axis: OpenSim's equation."""
        place = self.a + u * self.n
        return 2.0 * place @ self.n - 4.0 * self.ring * (place[:2] @ self.n[:2]) / np.hypot(*place[:2])

    def slope(self, u: float) -> float:
        place = self.a + u * self.n
        flat = np.hypot(*place[:2])
        bend = self.n[:2] @ self.n[:2] / flat - (place[:2] @ self.n[:2]) ** 2 / flat**3
        return float(2.0 - 4.0 * self.ring * bend)

    def found(self, ahead: float = 0.0) -> np.ndarray:
        """Where Levenberg's and Marquardt's method as MINPACK has it ends, from a on; with slopes over that, if any."""
        options = {"factor": 0.2, "ftol": 1e-4, "xtol": 1e-4, "gtol": 0.0, "maxfev": 400}

        def slope(u: float) -> float:
            return (self.excess(u + ahead) - self.excess(u)) / ahead if ahead else self.slope(u)

        u = leastsq(lambda u: self.excess(u[0]), [0.0], Dfun=lambda u: [[slope(u[0])]], **options)[0][0]
        return self.a + u * self.n


def test_the_equation_of_the_nearest_place_and_its_derivative():
    rng = np.random.default_rng(1)
    ends, u, ring = rng.normal(size=(200, 2, 3)) * 0.1, rng.normal(size=200) * 0.1, 0.07
    lines = [Line(*pair, ring) for pair in ends]
    n = np.array([line.n for line in lines])
    along, flat = np.sum(ends[:, 0] * n, axis=1), np.sum(ends[:, 0, :2] * n[:, :2], axis=1)
    square, rest = np.sum(n[:, :2] ** 2, axis=1), np.sum(ends[:, 0, :2] ** 2, axis=1)
    got = evaluate(wrap_torus.circle_slope, u, along, flat, square, rest, ring)
    step = 1e-6
    slope = [(one.excess(x + step) - one.excess(x - step)) / (2.0 * step) for one, x in zip(lines, u, strict=True)]
    np.testing.assert_allclose(got[:, 0], [one.excess(x) for one, x in zip(lines, u, strict=True)], atol=1e-5)
    np.testing.assert_allclose(got[:, 1], slope, rtol=2e-4, atol=2e-3)


def test_of_several_nearest_places_the_one_is_found_that_minpack_finds():
    """Some lines lie so that the last bit says which one that is."""
    for size, count in ((0.05, 2000), (0.2, 1000)):
        ends = (np.random.default_rng(2).normal(size=(count, 2, 3)) * size).astype(np.float32).astype(float)
        got = evaluate(wrap_torus.place_from, ends[:, 0], ends[:, 1], 0.8 * size)
        expected = np.array([Line(*pair, 0.8 * size).found() for pair in ends])
        off = np.linalg.norm(got - expected, axis=1)
        assert np.mean(off < 0.004 * size) > 0.9985
        assert np.median(off) < 1e-5 * size


def test_opensims_search_takes_differences_over_ten_micrometres():
    """MINPACK's steps with such slopes to the last digits in float64, and within the digits of a GPU's numbers."""
    ends = (np.random.default_rng(2).normal(size=(1500, 2, 3)) * 0.05).astype(np.float32).astype(float)
    expected = np.array([Line(*pair, 0.04).found(1e-5) for pair in ends])
    on_host = np.array([torus.place_from(*pair, 0.04) for pair in ends])
    assert np.mean(np.linalg.norm(on_host - expected, axis=1) < 1e-12) > 0.999
    off = np.linalg.norm(evaluate(wrap_torus.place_as_opensim, ends[:, 0], ends[:, 1], 0.04) - expected, axis=1)
    assert np.mean(off < 2e-4) > 0.9985
    assert np.mean(off < 1e-6) > 0.98


@pytest.mark.parametrize(
    ("a", "b", "center"),
    [
        (  # the search ends before it is where it would go, at 8e-6 m from there
            (0.034684588143250046, 0.09487475591215755, -0.00805625813452542),
            (0.03850316736376841, -0.02265295090001576, -0.019998265383426996),
            (0.021181351463677986, -0.005945616046478804, 0.0),
        ),
        (
            (0.02424179721890204, -0.019362764256606064, 0.08366970330946194),
            (0.039820188546672325, -0.0345365163538951, 0.12182562981919857),
            (0.021965823405733487, -0.0012258067172808318, 0.0),
        ),
    ],
)
def test_the_ring_is_met_where_opensim_meets_it(a, b, center):
    """What WrapTorus::findClosestPoint of OpenSim 4.6 gives for a ring of 22 mm."""
    ends = np.array(a), np.array(b)
    place = min((torus.place_from(*ends, 0.022), torus.place_from(*ends[::-1], 0.022)), key=distance)
    np.testing.assert_allclose(place[:2] * 0.022 / np.hypot(*place[:2]), center[:2], rtol=0.0, atol=1e-13)


def distance(place: np.ndarray) -> float:
    return float(np.hypot(np.hypot(*place[:2]) - 0.022, place[2]))


def test_where_there_is_one_nearest_place_beyond_doubt_both_searches_end_there():
    """Lines that run nearly along the axis, as muscles do through a ring, and lines of any direction."""
    ring, rng = 0.04, np.random.default_rng(3)
    n = rng.normal(size=(3000, 3)) * [0.3, 0.3, 1.0]
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    middle = rng.normal(size=(3000, 3)) * 0.03
    a, b = (middle + n * rng.uniform(*reach, 3000)[:, None] for reach in ((-0.1, -0.02), (0.02, 0.1)))
    one = evaluate(wrap_torus.one_place, a, b, ring).astype(bool)
    assert 0.3 < one.mean() < 0.9
    from_a, from_b = (evaluate(wrap_torus.place_from, *pair, ring)[one] for pair in ((a, b), (b, a)))
    np.testing.assert_allclose(from_a, from_b, atol=2e-7)
    u = np.linspace(-0.2, 0.2, 400)
    slopes = [
        min(line.slope(x) for x in u)
        for line in (Line(*pair, ring) for pair in zip(a[one][:50], b[one][:50], strict=True))
    ]
    assert min(slopes) >= 1.0 - 1e-3


def test_no_detour_to_a_torus_is_shorter_than_what_the_distance_from_its_plane_says():
    ring, rng = TorusSurface("b", (0.0, 0.0, 0.0), 0.012, 0.04), np.random.default_rng(4)
    a, b = rng.normal(size=(2, 1500, 3)) * [0.06, 0.06, 0.1]
    bound = evaluate(wrap_torus.least_detour, a, b, ring.inner_radius)
    found = [touch(ring, "hybrid", IN_PLANE, *pair) for pair in zip(a, b, strict=True)]
    around = np.array([one.kind >= BESIDE for one in found])
    detour = np.array(
        [
            np.linalg.norm(one.first - p) + one.length + np.linalg.norm(q - one.second) - np.linalg.norm(q - p)
            if one.kind >= BESIDE else 0.0
            for one, p, q in zip(found, a, b, strict=True)
        ]
    )  # fmt: skip
    assert np.sum(around & (bound > 0.0)) > 100
    assert np.all(bound[around] <= detour[around] + 1e-6)
    apart = (a[:, 2] * b[:, 2] > 0.0) & (np.minimum(np.abs(a[:, 2]), np.abs(b[:, 2])) > ring.inner_radius)
    assert np.all(bound[apart] > 0.0)
    assert np.all(bound[~apart] <= 1e-6)
