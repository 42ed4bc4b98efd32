"""Metabolic power of recorded muscles against the published formulas in float64."""

import numpy as np
import pytest

from small_leg import motion, small_leg
from warpmuscle.core.errors import ArgumentError
from warpmuscle.core.number_rows import first_number
from warpmuscle.inverse.body_model import BodyModel
from warpmuscle.inverse.recordings.metabolic import metabolic_powers
from warpmuscle.inverse.static_optimization import static_optimization

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")


@pytest.fixture(scope="module")
def body(tmp_path_factory) -> BodyModel:
    return BodyModel(small_leg(tmp_path_factory.mktemp("leg")), "cpu")


@pytest.fixture(scope="module")
def found(body):
    return static_optimization(body, motion(6), reserve=10.0, pennation=True)


def test_margaria_counts_the_work_of_fibres_at_25_and_at_minus_120_percent(body, found):
    power = metabolic_powers(body, found)["margaria"]
    width = [first_number(body.muscle(name).l_opt) * np.sin(first_number(body.muscle(name).pennation))
             for name in body.muscles]  # fmt: skip
    cosine = np.sqrt(1.0 - np.square(np.array(width) / found.fibre_length))
    work = -found.force / cosine * found.fibre_velocity  # of rigid tendons and active forces alone
    assert (work > 0.0).any()
    assert (work < 0.0).any()
    assert np.abs(work).max() > 1.0
    np.testing.assert_allclose(power, np.where(work > 0.0, work / 0.25, -work / 1.2), rtol=1e-3, atol=1e-3)


def test_formulas_differ_as_their_definitions_say(body, found):
    own, positive = metabolic_powers(body, found), metabolic_powers(body, found, "positive")
    assert list(own) == ["wang", "umberger", "bhargava", "margaria", "bhargava strict"]
    assert all(np.isfinite(values).all() for values in own.values())
    # Where excitations are activations, Wang's heat is Bhargava's, and his work the positive one.
    np.testing.assert_allclose(positive["bhargava"], own["wang"], rtol=1e-5)
    given_back = own["bhargava"] < positive["bhargava"] - 1e-3
    assert (found.fibre_velocity[given_back] > 0.0).all()
    assert given_back.any()
    assert (own["bhargava strict"] >= 0.0).all()
    assert (own["bhargava strict"] >= own["bhargava"] - 1e-4).all()


def test_what_cannot_be_counted_is_refused(body, found):
    with pytest.raises(ArgumentError, match="'all'"):
        metabolic_powers(body, found, "all")
    other = BodyModel(body.scene, "cpu")
    other.muscles = other.muscles[1:]
    with pytest.raises(ArgumentError, match="another model"):
        metabolic_powers(other, found)
