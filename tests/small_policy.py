"""Policies of random weights for tests, and a learning curve."""

import itertools
from dataclasses import replace

import numpy as np

from warpmuscle.formats import SceneLike
from warpmuscle.learning import EpisodeBatch, Task
from warpmuscle.learning.player import text_of
from warpmuscle.results.learned import CURVE, Layer, Learned, PolicyTable


def small_policy(observations=9, hidden=(17, 6), actions=4, seed=3, noise=None) -> PolicyTable:
    random = np.random.default_rng(seed)
    sizes = [observations, *hidden, actions]
    layers = [
        Layer(random.normal(size=(b, a)).astype(np.float32), random.normal(size=b).astype(np.float32))
        for a, b in itertools.pairwise(sizes)
    ]
    names = tuple(f"o{k}" for k in range(observations)), tuple(f"a{k}" for k in range(actions))
    mean, deviation = random.normal(size=observations), random.uniform(0.1, 2.0, observations)
    return PolicyTable(*names, mean.astype(np.float32), deviation.astype(np.float32), 5.0, tuple(layers), noise)


def learning_curve(rows: int) -> dict:
    return {name: np.linspace(0.0, 1.0, rows) for name in CURVE} | {"iteration": np.arange(1.0, rows + 1.0)}


def random_policy(scene: SceneLike, task: Task) -> Learned:
    """What a file would hold of a policy of random weights that has learnt a task in a scene."""
    batch = EpisodeBatch(scene, 1, "cpu", task)
    observed, actions = tuple(batch.senses.names), batch.actions.names
    policy = replace(small_policy(len(observed), (8,), len(actions)), observation=observed, action=actions)
    return Learned(policy, text_of(task), learning_curve(1), {})
