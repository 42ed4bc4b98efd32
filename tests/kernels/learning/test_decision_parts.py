"""What a decision adds to the terms of an objective, summed over muscles and bodies."""

import numpy as np
import warp as wp
from probes import filled

from warpmuscle.kernels.learning.decision_parts import OF_BODIES, OF_INSTANCE, OF_MUSCLES, AddedTerms, added_terms
from warpmuscle.kernels.structs import State


def test_what_is_added_is_the_sum_over_muscles_or_bodies_since_the_decision_before():
    random = np.random.default_rng(3)
    state = {"muscle_terms": (2, 2, 5), "body_terms": (2, 3, 4), "instance_terms": (2, 2)}
    terms = {name: random.uniform(1.0, 2.0, shape) for name, shape in state.items()}
    before = random.uniform(0.0, 0.5, (2, 3))
    added = filled(AddedTerms, part=[OF_MUSCLES, OF_BODIES, OF_INSTANCE], index=[1, 2, 0], before=before.copy())
    values = wp.zeros((2, 3), dtype=float, device="cpu")
    wp.launch(added_terms, (2, 3), [added, filled(State, **terms), 0.01, values], device="cpu")
    sums = np.stack(
        [terms["muscle_terms"][:, 1].sum(axis=1), terms["body_terms"][:, 2].sum(axis=1), terms["instance_terms"][:, 0]],
        axis=1,
    )
    np.testing.assert_allclose(values.numpy(), 0.01 * (sums - before), rtol=1e-6)
    np.testing.assert_allclose(added.before.numpy(), sums)
