"""Parameters to their precision, and as points of the unit cube."""

import numpy as np

from warpmuscle.optimization.unit_cube import from_unit, snap, to_unit
from warpmuscle.scene.parameters import Parameter


def test_snapping_rounds_to_the_grid_without_noise_and_stays_inside():
    parameters = [
        Parameter("a", 0.7, 0.5, 0.9, 0.01, "s"),
        Parameter("b", 0.0, -1.0, 1.0, 0.0, ""),
        Parameter("c", 0.0, 0.0, 1.0, 0.3, ""),
    ]
    values = np.array([[0.7049, 0.123456, 0.99], [0.2, -7.0, 0.46], [7.0, 7.0, -1.0]])
    assert snap(parameters, values).tolist() == [[0.7, 0.123456, 0.9], [0.5, -1.0, 0.6], [0.9, 1.0, 0.0]]


def test_snapping_is_idempotent():
    generator = np.random.default_rng(1)
    parameters = [Parameter("p", low, low, low + 1.7, step, "") for low in (-3.3, 0.1) for step in (0.01, 0.3, 1e-5)]
    once = snap(parameters, generator.uniform(-4, 3, (200, len(parameters))))
    np.testing.assert_array_equal(snap(parameters, once), once)


def test_points_of_the_cube_are_linear_or_logarithmic_between_the_ends():
    parameters = [Parameter("a", 2.0, 1.0, 5.0, 0.0, ""), Parameter("b", 1.0, 0.1, 10.0, 0.0, "", "log")]
    values = from_unit(parameters, np.array([[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]]))
    np.testing.assert_allclose(values, [[1.0, 0.1], [3.0, 1.0], [5.0, 10.0]], rtol=1e-12)
    np.testing.assert_allclose(to_unit(parameters, values), [[0.0, 0.0], [0.5, 0.5], [1.0, 1.0]], atol=1e-12)
    assert to_unit([Parameter("c", 1.0, 1.0, 1.0, 0.0, "")], np.array([1.0])).tolist() == [0.5]
