"""Arrays from files are compared with bounds that their own precision may not hold."""

import warnings

import numpy as np
import pytest

from warpmuscle.core.array_checks import check_numbers


@pytest.mark.parametrize("kind", ["f2", "f4", "f8", "i1", "u8"])
def test_arrays_of_every_precision_are_checked_without_a_warning(kind: str):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_numbers("a", np.array([0, 1, 100], kind), (3,))
        with pytest.raises(ValueError, match="a holds 100, and should lie between 0 and 50"):
            check_numbers("a", np.array([0, 1, 100], kind), (3,), 0, 50)


@pytest.mark.parametrize("kind", ["f2", "f4", "f8"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_refused_in_every_precision(kind: str, value: float):
    with pytest.raises(ValueError, match=f"a holds {value}"):
        check_numbers("a", np.array([0, value, 1], kind), (3,))
