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
    frames = [[getattr(one, name)[-2:] for one in motions] for name in ("com", "com_velocity")]
    before, last = np.moveaxis(np.array(frames), 2, 0)
    place, velocity = 2.0 * last - before  # a frame is of the start of a step, what is earned of its end
    low = np.maximum(1.0 - place[:, 1], 0.0) / 0.2
    off = (place[:, 2] - 0.37) / 0.3
    still = np.exp(-np.sum(velocity**2, axis=1) / 0.3**2)
    earned = 20.0 * 0.01 * np.exp(-(low**2) - off**2) * (1.0 + 2.0 * still) / 3.0
    np.testing.assert_allclose(batch.judge.gains.reward.numpy(), earned, rtol=1e-2)
