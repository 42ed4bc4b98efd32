"""The linear-quadratic problem beside one dense system of equations for all unknowns."""

import numpy as np

from warpmuscle.inverse.simulated_ground.linear_quadratic import Costs, solve

STEPS, STATES, CONTROLS = 6, 4, 2


def problem(seed: int = 0):
    random = np.random.default_rng(seed)
    a, b = random.normal(size=(STEPS, STATES, STATES)), random.normal(size=(STEPS, STATES, CONTROLS))
    d = random.normal(size=(STEPS, STATES))
    both = random.normal(size=(STATES + CONTROLS, STATES + CONTROLS))
    both = both @ both.T + np.eye(STATES + CONTROLS)
    last = random.normal(size=(STATES, STATES))
    costs = Costs(
        both[:STATES, :STATES], last @ last.T + np.eye(STATES), both[STATES:, STATES:], both[STATES:, :STATES],
        random.normal(size=(STEPS + 1, STATES)), random.normal(size=(STEPS, CONTROLS)),
    )  # fmt: skip
    return a, b, d, costs


def dense(a, b, d, costs):
    """States and controls by the conditions of the first order, with a multiplier for each step."""
    states, controls = (STEPS + 1) * STATES, STEPS * CONTROLS
    size = states + controls
    bend, slope = np.zeros((size, size)), np.concatenate([costs.slope.ravel(), costs.push.ravel()])
    rule, right = np.zeros((STEPS * STATES, size)), np.zeros(STEPS * STATES)
    for k in range(STEPS + 1):
        x = slice(k * STATES, (k + 1) * STATES)
        bend[x, x] = costs.state if k < STEPS else costs.last
        if k == STEPS:
            continue
        u, row = slice(states + k * CONTROLS, states + (k + 1) * CONTROLS), slice(k * STATES, (k + 1) * STATES)
        bend[u, u], bend[u, x], bend[x, u] = costs.control, costs.cross, costs.cross.T
        rule[row, x], rule[row, u], rule[row, (k + 1) * STATES : (k + 2) * STATES] = a[k], b[k], -np.eye(STATES)
        right[row] = -d[k]
    whole = np.block([[bend, rule.T], [rule, np.zeros((len(rule), len(rule)))]])
    found = np.linalg.solve(whole, np.concatenate([-slope, right]))
    return found[:states].reshape(-1, STATES), found[states:size].reshape(-1, CONTROLS)


def test_states_and_controls_are_those_of_one_dense_system():
    given = problem()
    found = solve(*given)
    states, controls = dense(*given)
    np.testing.assert_allclose(found.state, states, rtol=1e-8, atol=1e-8)
    np.testing.assert_allclose(found.control, controls, rtol=1e-8, atol=1e-8)


def test_gains_answer_a_state_as_the_rest_of_the_way_would():
    a, b, d, costs = problem(1)
    found, away = solve(a, b, d, costs), np.array([0.3, -0.2, 0.1, 0.4])
    x, steps = found.state[2] + away, []
    for k in range(2, STEPS):
        u = found.control[k] + found.gain[k] @ (x - found.state[k])
        steps.append(u)
        x = a[k] @ x + b[k] @ u + d[k]
    fixed = costs.slope[2:].copy(), costs.state
    rest = costs._replace(slope=fixed[0], push=costs.push[2:])

    def cost(controls):
        x, total = found.state[2] + away, 0.0
        for k, u in enumerate(controls):
            total += 0.5 * x @ rest.state @ x + rest.slope[k] @ x + 0.5 * u @ rest.control @ u
            total += rest.push[k] @ u + u @ rest.cross @ x
            x = a[k + 2] @ x + b[k + 2] @ u + d[k + 2]
        return total + 0.5 * x @ rest.last @ x + rest.slope[-1] @ x

    best, random = cost(steps), np.random.default_rng(2)
    assert all(cost(np.array(steps) + 0.01 * random.normal(size=(len(steps), CONTROLS))) > best for _ in range(20))
