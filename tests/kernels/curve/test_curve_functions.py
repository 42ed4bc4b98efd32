"""Sets of curves: what one forgets is named as it is imported, and a step is compiled with one set alone."""

from typing import Any

import numpy as np
import pytest
import warp as wp
from probes import evaluate

from warpmuscle.kernels.curve import curves
from warpmuscle.kernels.curve.curve_functions import SIGNATURES, CurveFunctions, checked
from warpmuscle.kernels.curve.curve_sets import CURVES
from warpmuscle.kernels.curve.curves import LEE, MILLARD, SETS, module_of
from warpmuscle.kernels.curve.custom_curves import with_curves
from warpmuscle.kernels.curve.lee_curves import CURVES as LEE_CURVES
from warpmuscle.kernels.curve.lee_curves import lee_passive
from warpmuscle.kernels.muscle import muscle

LENGTH = np.linspace(0.3, 1.9, 33)
NO_SET = len(CURVES) + 7


def test_every_set_that_a_scene_may_name_has_all_its_curves():
    assert list(SETS) == list(CURVES.values())
    assert all(getattr(functions, field) is not None for functions in SETS.values() for field in SIGNATURES)


@pytest.mark.parametrize("field", SIGNATURES)
def test_a_curve_that_a_set_forgets_is_named(field: str):
    forgetful = LEE_CURVES._replace(**{field: None})
    with pytest.raises(TypeError, match=rf"curve set 'bell' has no '{field}': CURVES in bell_curves.py needs"):
        checked("bell", forgetful)


def plain(length: float) -> float:
    return length


@wp.func
def whole_number(length: float) -> int:
    return 1


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (None, "bell_curves.py has no CURVES, a `curve_functions.CurveFunctions`"),
        (CurveFunctions(), "has no 'active'"),
        (
            LEE_CURVES._replace(passive=plain),
            r"'passive' .* must be a Warp function \(length\) -> float",
        ),
        (LEE_CURVES._replace(velocity=lee_passive), r"must be a Warp function \(speed, activation\) -> wp.vec2"),
        (LEE_CURVES._replace(tendon=lee_passive), r"'tendon' .* must be a Warp function \(strain\) -> wp.vec2"),
        (LEE_CURVES._replace(active=whole_number), r"'active' .* must be a Warp function \(length\) -> float"),
    ],
)
def test_what_is_no_set_of_curves_is_told(given: Any, message: str):
    with pytest.raises(TypeError, match=f"curve set 'bell'.*{message}"):
        checked("bell", given)


def test_a_name_without_a_file_is_told():
    with pytest.raises(TypeError, match=r"curve set 'bell' has no file bell_curves.py"):
        module_of("bell")


def test_a_number_of_no_set_has_no_numbers_rather_than_those_of_another():
    assert np.isnan(evaluate(curves.active_force_length, NO_SET, LENGTH)).all()
    assert np.isnan(evaluate(curves.passive_force_length, NO_SET, LENGTH)).all()
    assert np.isnan(evaluate(curves.force_velocity_slope, NO_SET, LENGTH, 1.0)).all()
    assert np.isnan(evaluate(curves.tendon_force_slope, NO_SET, LENGTH)).all()


def forces(function: Any, number: int) -> np.ndarray:
    """What a function of fibre forces gives for a number of curves, in a kernel of its own."""

    @wp.kernel(module="unique", enable_backward=False)
    def kernel(length: wp.array[float], force: wp.array[float]):
        i = wp.tid()
        force[i] = function(number, 0.6, length[i], -0.2, 0.1)

    force = wp.zeros(len(LENGTH), dtype=float, device="cpu")
    wp.launch(kernel, len(LENGTH), [wp.array(np.float32(LENGTH), device="cpu"), force], device="cpu")
    return force.numpy()


@pytest.mark.parametrize("number", [LEE, MILLARD])
def test_a_function_made_for_one_set_has_its_curves_whatever_number_it_is_given(number: int):
    expected = forces(muscle.fibre_force, number)
    assert expected.max() > 0.2
    np.testing.assert_array_equal(forces(with_curves(muscle.fibre_force, None, number), NO_SET), expected)
    assert with_curves(muscle.pennation_cosine, None, number) is muscle.pennation_cosine
