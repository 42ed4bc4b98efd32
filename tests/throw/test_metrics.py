"""Coefficients of determination and correlations against closed forms, over the samples that count."""

import numpy as np

from warpmuscle.throw.metrics import Agreement, correlation, determination, leave_one_out, null
from warpmuscle.throw.signals import Knots

TIME = np.linspace(0.0, 1.0, 101)


def test_determination_counts_errors_in_parts_of_the_variance():
    recorded = np.stack([np.sin(6.0 * TIME), TIME], axis=1)[None]
    error = np.full_like(recorded, 0.1)
    got = determination(recorded + error, recorded, np.ones((1, 101)))
    np.testing.assert_allclose(got[0], 1.0 - 0.01 / recorded[0].var(axis=0))
    assert np.all(determination(recorded, recorded, np.ones((1, 101))) == 1.0)


def test_samples_beyond_a_motions_end_do_not_count():
    recorded = np.sin(6.0 * TIME)[None, :, None]
    simulated, valid = recorded.copy(), np.ones((1, 101))
    simulated[:, 60:], valid[:, 60:] = 100.0, 0.0
    assert determination(simulated, recorded, valid)[0, 0] == 1.0
    assert correlation(simulated, recorded, valid)[0][0] == 1.0


def test_the_trivial_baseline_is_the_mean_of_the_others():
    recorded = np.stack([np.sin(6.0 * TIME), np.sin(6.0 * TIME) + 0.1, np.sin(6.0 * TIME) - 0.1])[:, :, None]
    got = leave_one_out(recorded, np.ones((3, 101)))
    np.testing.assert_allclose(got[0], 1.0)
    np.testing.assert_allclose(got[1], 1.0 - 0.15**2 / recorded[1].var())
    assert np.isnan(leave_one_out(recorded[:1], np.ones((1, 101)))).all()


def test_all_bars_count_at_the_same_time():
    fine = {"r2": np.full((1, 3), 0.9995), "velocity_r2": np.full((1, 3), 0.98), "hand_error": np.array([0.01])}
    signals = {"correlation": np.array([0.95]), "by_synergy": np.full((1, 5), 0.9)}
    assert Agreement(**fine, **signals).good().all()
    assert not Agreement(**(fine | {"hand_error": np.array([0.03])}), **signals).good().any()
    assert not Agreement(**(fine | {"velocity_r2": np.array([[0.98, 0.96, 0.98]])}), **signals).good().any()


def test_knots_give_back_signals_that_are_straight_between_them():
    knots = Knots(TIME)
    values = np.random.default_rng(0).uniform(size=(2, 3, len(knots)))
    assert len(knots) == 21
    np.testing.assert_allclose(knots.fitted(knots.sampled(values)), values, atol=2e-3)
    np.testing.assert_allclose(knots.sampled(values)[:, ::5], values.transpose(0, 2, 1), atol=1e-12)


def test_signals_are_judged_beside_those_of_another_motion():
    """Two signals a motion: the first is alike in all motions, the second is its own."""
    rng = np.random.default_rng(0)
    common = np.sin(6.0 * TIME)
    extracted = np.stack([np.stack([common, rng.normal(size=101)], axis=1) for _ in range(3)])
    valid = np.ones((3, 101))
    together, single = null(extracted, extracted, valid)
    np.testing.assert_allclose(single[:, 0], 1.0)
    pairs = [abs(np.corrcoef(extracted[i, :, 1], extracted[j, :, 1])[0, 1]) for i in range(3) for j in range(i)]
    assert np.abs(single[:, 1]).max() <= max(pairs) + 1e-12
    assert np.all(together < 0.999)
    assert null(extracted[:1], extracted[:1], valid[:1]) == (None, None)
    fine = {"r2": np.full((3, 3), 0.9995), "velocity_r2": np.full((3, 3), 0.98), "hand_error": np.full(3, 0.01)}
    swapped = extracted[[1, 0, 2]]
    for fitted, good in ((extracted, [True] * 3), (swapped, [False, False, True])):
        _, individual = correlation(fitted, extracted, valid)
        _, other = null(fitted, extracted, valid)
        a = Agreement(**fine, correlation=np.full(3, 0.95), by_synergy=individual, null=together, null_by_synergy=other)
        assert a.good().tolist() == good  # though all together they correlate by 0.95
        assert a.with_signals_kept().good().all()
