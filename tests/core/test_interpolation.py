"""Values at other moments, against NumPy's interpolation of one column."""

import numpy as np

from warpmuscle.core.interpolation import at_moments


def test_every_column_is_that_of_numpys_interpolation_also_beyond_the_ends():
    random = np.random.default_rng(1)
    time, moments = np.sort(random.random(20)), random.uniform(-0.5, 1.5, (4, 7))
    values = random.normal(size=(20, 3, 2))
    found = at_moments(time, values, moments)
    assert found.shape == (4, 7, 3, 2)
    for k in np.ndindex(3, 2):
        np.testing.assert_allclose(found[(..., *k)], np.interp(moments, time, values[(..., *k)]), atol=1e-12)
