"""The tasks of `warpmuscle example everyday`: what is earned, and that a body sits until it moves."""

from pathlib import Path

import numpy as np
import pytest

from importing import importable_from
from warpmuscle.core.status import Status
from warpmuscle.examples import write
from warpmuscle.formats import load
from warpmuscle.learning import EpisodeBatch
from warpmuscle.scene.trusted_code import trust

REWARDS = ("alive", "upright", "effort", "action", "action_rate", "side", "heading", "objective", "failure")
SEEN = ("com", "com_velocity", "body_position", "body_orientation")
TORSO, FEET, ARMS = 1, (11, 12), ((5, 9), (6, 10))


def last_of(frames: np.ndarray) -> np.ndarray:
    """At the end of the last step: a frame is of a step's start, what is earned of its end."""
    return np.asarray(2.0 * frames[-1] - frames[-2])


def stands(at: dict[str, np.ndarray]) -> float:
    """What standing earns, by hand."""
    off = (at["com"] - at["body_position"][list(FEET)].mean(axis=0))[[0, 2]]
    low = max(1.0 - at["body_position"][0, 1], 0.0) / 0.25
    x, _, z, _ = at["body_orientation"][TORSO]
    upright = max(1.0 - 2.0 * (x * x + z * z), 0.0)
    still = np.exp(-np.sum(at["com_velocity"] ** 2) / 0.3**2)
    return float(np.exp(-np.sum(off**2) / 0.25**2) * (0.2 + 0.4 * np.exp(-(low**2)) * upright * (1.0 + still)))


def arms(at: dict[str, np.ndarray]) -> float:
    """What raised arms cost, by hand."""
    height = at["body_position"][:, 1]
    return float(sum(np.clip(10.0 * (height[lower] - height[upper] + 0.2), 0.0, 4.0) ** 2 for upper, lower in ARMS))


@pytest.mark.usefixtures("unoptimized_test")
def test_a_body_sits_on_its_seat_and_earns_what_its_height_place_and_speed_say(tmp_path: Path):
    write("everyday", tmp_path)
    scene = load(tmp_path / "sit_to_stand.toml")
    trust(scene, tmp_path)
    assert scene.learning is not None
    for name in REWARDS:
        setattr(scene.learning.rewards, name, 0.0)
    with importable_from(tmp_path):
        batch = EpisodeBatch(scene, 2, "cpu", seed=1, record=[0, 1], record_rate=2000.0)
        for _ in range(20):
            batch.step(restart=False)
    assert list(batch.rollout.status()) == [Status.RUNNING] * 2
    motions = [batch.rollout.recording(k) for k in range(2)]
    sits = np.array([motion.root_position[:, 1] for motion in motions])
    assert (np.abs(sits - sits[:, :1]) < 0.06).all()
    now = [{name: last_of(getattr(one, name)) for name in SEEN} for one in motions]
    earned = 20.0 * 0.01 * np.array([stands(one) for one in now]) - 0.5 * 0.01 * np.array([arms(one) for one in now])
    np.testing.assert_allclose(batch.judge.gains.reward.numpy(), earned, rtol=1e-2)
