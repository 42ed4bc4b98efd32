"""Points of paths that count at times only: their weights, and paths that slide onto them and off."""

import numpy as np
import warp as wp
from probes import evaluate

from leg_paths import KNEE_BENT, gradient, on_the_knee, with_condition
from warpmuscle.core.arrays import structs_to_device
from warpmuscle.kernels.path import conditions
from warpmuscle.scene import Condition


@wp.kernel(enable_backward=False)
def multiply(a: wp.array[conditions.Weight], b: wp.array[conditions.Weight], product: wp.array[conditions.Weight]):
    i = wp.tid()
    product[i] = conditions.both(a[i], conditions.without(b[i]))


def test_products_of_weights_change_by_the_product_rule():
    """Of a(t) (1 - b(t)): the rate and the gradient are a' (1 - b) - a b'."""
    rng = np.random.default_rng(0)
    a, b = (
        {"value": rng.uniform(size=50), "rate": rng.normal(size=50), "gradient": rng.normal(size=(50, 3))}
        for _ in range(2)
    )
    product = wp.zeros(50, dtype=conditions.Weight, device="cpu")
    wp.launch(
        multiply, 50, [*(structs_to_device(conditions.Weight, one, "cpu") for one in (a, b)), product], device="cpu"
    )
    found, rest = product.numpy(), 1.0 - b["value"]
    np.testing.assert_allclose(found["value"], a["value"] * rest, atol=1e-6)
    np.testing.assert_allclose(found["rate"], a["rate"] * rest - a["value"] * b["rate"], atol=1e-6)
    expected = a["gradient"] * rest[:, None] - a["value"][:, None] * b["gradient"]
    np.testing.assert_allclose(found["gradient"], expected, atol=1e-6)


def test_weight_of_a_condition_is_half_at_its_ends_and_its_slope_is_its_derivative():
    angle, h = np.linspace(-2.0, 2.0, 400), 1e-3
    value = evaluate(conditions.condition_weight, [-0.7, 0.9], -0.7, 0.9, 0.2)[:, 0]
    np.testing.assert_allclose(value, 0.5, atol=1e-6)
    weight = [evaluate(conditions.condition_weight, angle + d, -0.7, 0.9, 0.2) for d in (-h, 0.0, h)]
    np.testing.assert_allclose(weight[1][:, 1], (weight[2] - weight[0])[:, 0] / (2.0 * h), atol=5e-3)


def test_conditional_points_count_within_the_interval_and_not_outside():
    angles = np.linspace(-1.2, 1.2, 481)
    through = with_condition(None)
    paths = {"on": through, "off": [through[0], through[-1]], "both": with_condition(KNEE_BENT)}
    length = on_the_knee(angles, paths)[1].length
    inside = (angles > -0.35) & (angles < 0.25)
    outside = (angles < -0.65) | (angles > 0.55)
    np.testing.assert_allclose(length[inside, 2], length[inside, 0], atol=1e-6)
    np.testing.assert_allclose(length[outside, 2], length[outside, 1], atol=1e-6)
    assert np.all(length[:, 2] < length[:, 0] + 1e-6)
    assert np.all(length[:, 2] > length[:, 1] - 1e-6)


def test_a_path_starts_and_ends_at_points_that_count():
    """Its ends come in and go like other points: the length is that of the points between, beside the ends' weights."""
    angles = np.linspace(-1.2, 1.2, 2401)
    through = with_condition(None)
    first, last = with_condition(None), with_condition(None)
    first[0].condition = last[-1].condition = KNEE_BENT
    paths = {"on": through, "without first": through[1:], "without last": through[:-1], "first": first, "last": last}
    stages, geometry = on_the_knee(angles, paths)
    length = geometry.length
    inside = (angles > -0.35) & (angles < 0.25)
    outside = (angles < -0.65) | (angles > 0.55)
    for k in (1, 2):
        np.testing.assert_allclose(length[inside, 2 + k], length[inside, 0], atol=1e-6)
        np.testing.assert_allclose(length[outside, 2 + k], length[outside, k], atol=1e-6)
    arm = gradient(stages, geometry)
    for k in (3, 4):
        slope = np.gradient(length[:, k].astype(float), angles)
        np.testing.assert_allclose(np.linalg.norm(arm[1:-1, k], axis=-1), np.abs(slope[1:-1]), atol=4e-3)


def test_length_and_moment_arm_have_no_jump_where_a_point_comes_in():
    """Halving the distance of poses halves the largest change from pose to pose."""
    changes = []
    for count in (400, 800):
        stages_, geometry = on_the_knee(np.linspace(-1.2, 1.2, count), {"both": with_condition(KNEE_BENT)})
        arm = gradient(stages_, geometry).sum(axis=(1, 2))
        changes.append([np.abs(np.diff(values)).max() for values in (geometry.length[:, 0], arm)])
    np.testing.assert_allclose(np.array(changes[1]) / changes[0], 0.5, atol=0.05)


def test_instances_may_have_their_own_points_and_conditions():
    heights = np.linspace(-0.2, 0.0, 5)
    low = np.array([-0.5, -0.5, 0.3, 0.3, 0.3])
    varied = with_condition(Condition("lKnee", low, 1.0, 0.1))
    varied[0].position = (0.0, heights, 0.05)
    together = on_the_knee(np.zeros(5), {"m": varied})[1].length[:, 0]
    for i in range(5):
        varied = with_condition(Condition("lKnee", float(low[i]), 1.0, 0.1))
        varied[0].position = (0.0, float(heights[i]), 0.05)
        assert together[i] == on_the_knee(np.zeros(1), {"m": varied})[1].length[0, 0]
