"""Means of the weights of policies."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools" / "research"))

from mean_of_policies import main, mean_of  # noqa: E402

from warpmuscle.core.errors import Error  # noqa: E402
from warpmuscle.examples import write  # noqa: E402
from warpmuscle.formats import load  # noqa: E402
from warpmuscle.learning.player import task_of  # noqa: E402
from warpmuscle.learning.policy import actions_of  # noqa: E402
from warpmuscle.results.learned import ClippedNoise, Layer, PolicyTable  # noqa: E402
from warpmuscle.results.result import read  # noqa: E402


def a_policy(seed: int) -> PolicyTable:
    """One linear layer, so that the mean of weights is the mean of actions."""
    random = np.random.default_rng(seed)
    weight, bias = (random.normal(size=size).astype(np.float32) for size in ((2, 3), 2))
    zero, one = (np.full(3, value, dtype=np.float32) for value in (0.0, 1.0))
    return PolicyTable(("a", "b", "c"), ("x", "y"), zero, one, 8.0, (Layer(weight, bias),))


def test_a_mean_acts_as_all_do_in_the_mean():
    policies = [a_policy(k) for k in range(1, 6)]
    seen = np.random.default_rng(6).normal(size=(20, 3)).astype(np.float32)
    expected = np.mean([actions_of(policy, seen) for policy in policies], axis=0)
    np.testing.assert_allclose(actions_of(mean_of(policies), seen), expected, atol=1e-5)


def test_noise_is_the_mean_and_others_are_refused():
    one, other = (replace(a_policy(k), noise=ClippedNoise(np.full(2, k, dtype=np.float32), -1.0, 1.0)) for k in (1, 4))
    noise = mean_of([one, one, other]).noise
    assert noise is not None
    np.testing.assert_allclose(noise.deviation, 2.0)
    with pytest.raises(Error, match="observe or move different things"):
        mean_of([one, one, replace(other, action=("x", "z"))])
    wider = Layer(np.zeros((2, 4), dtype=np.float32), np.zeros(2, dtype=np.float32))
    with pytest.raises(Error, match="different layers"):
        mean_of([one, replace(other, layers=(wider,))])


def test_the_file_holds_the_given_scene_and_every_command(tmp_path: Path):
    write("policies", tmp_path)
    one, other, scene = (tmp_path / f"gait2392_arms_{name}" for name in ("feet.h5", "like_people.h5", "feet.toml"))
    main([one, other], scene, tmp_path / "mean.h5")
    found, first = read(tmp_path / "mean.h5"), read(one)
    assert found.learned is not None
    assert first.learned is not None
    assert task_of(found.learned) == load(str(scene)).learning
    assert len(found.learned.curve["iteration"]) == 1
    assert found.command.splitlines() == [
        *first.command.splitlines(), *read(other).command.splitlines(),
        "python tools/research/mean_of_policies.py gait2392_arms_feet.h5 gait2392_arms_like_people.h5 "
        "gait2392_arms_feet.toml -o mean.h5",
    ]  # fmt: skip
    assert found.learned.policy.mean.shape == first.learned.policy.mean.shape
