"""Means of the weights of two policies."""

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


def test_a_policy_between_two_acts_between_them():
    one, other = a_policy(1), a_policy(2)
    seen = np.random.default_rng(3).normal(size=(20, 3)).astype(np.float32)
    apart = actions_of(other, seen) - actions_of(one, seen)
    for share in (0.0, 0.25, 1.0):
        moved = actions_of(mean_of(one, other, share), seen) - actions_of(one, seen)
        np.testing.assert_allclose(moved, share * apart, atol=1e-5)


def test_noise_is_between_the_two_and_others_are_refused():
    one, other = (replace(a_policy(k), noise=ClippedNoise(np.full(2, k, dtype=np.float32), -1.0, 1.0)) for k in (1, 2))
    noise = mean_of(one, other, 0.25).noise
    assert noise is not None
    np.testing.assert_allclose(noise.deviation, 1.25)
    with pytest.raises(Error, match="observe or move something else"):
        mean_of(one, replace(other, action=("x", "z")), 0.5)
    wider = Layer(np.zeros((2, 4), dtype=np.float32), np.zeros(2, dtype=np.float32))
    with pytest.raises(Error, match="other layers"):
        mean_of(one, replace(other, layers=(wider,)), 0.5)


def test_the_file_holds_the_given_scene_and_every_command(tmp_path: Path):
    write("policies", tmp_path)
    one, other, scene = (tmp_path / f"gait2392_arms_{name}" for name in ("feet.h5", "like_people.h5", "feet.toml"))
    main(one, other, scene, 0.5, tmp_path / "mean.h5")
    found, first = read(tmp_path / "mean.h5"), read(one)
    assert found.learned is not None
    assert first.learned is not None
    assert task_of(found.learned) == load(str(scene)).learning
    assert len(found.learned.curve["iteration"]) == 1
    assert found.command.splitlines() == [
        *first.command.splitlines(), *read(other).command.splitlines(),
        "python tools/research/mean_of_policies.py gait2392_arms_feet.h5 gait2392_arms_like_people.h5 "
        "gait2392_arms_feet.toml --share 0.5 -o mean.h5",
    ]  # fmt: skip
    assert found.learned.policy.mean.shape == first.learned.policy.mean.shape
