"""A gait that is imitated: what its own controller does earns nearly all, and the clock stands as the gait does."""

import msgspec
import numpy as np
import pytest

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.gait.foot_contact import touch_downs
from warpmuscle.kernels.rewards import IMITATION, TERMS
from warpmuscle.learning import EpisodeBatch, Imitation, Rewards, Sense, Task, Variation
from warpmuscle.learning.imitation import BINS, Gait, gait_of
from warpmuscle.learning.symmetry import BodySymmetry
from warpmuscle.scene.norms import PERCENT_OF_BIN, WALKING
from warpmuscle.simulation.rollout import Rollout

SCENE = "walk56_person"
NOTHING = dict.fromkeys(TERMS, 0.0)


@pytest.fixture(scope="module")
def batch() -> EpisodeBatch:
    rewards = Rewards(**(NOTHING | {"imitation": 1.0}), imitation_width=0.3)
    task = Task(
        observations={"clock": Sense(), "coordinates": Sense()}, imitation=Imitation(norm="Fukuchi 2018"),
        rewards=rewards, symmetric=True, variation=Variation(start_states=12, start_after=0.0, velocity_noise=0.0),
    )  # fmt: skip
    return EpisodeBatch(SCENE, 12, "cpu", task, threads=1)


@pytest.fixture(scope="module")
def walker() -> Rollout:
    rollout = Rollout(SCENE, 1, "cpu", record=[0], threads=1)
    rollout.run()
    return rollout


@pytest.fixture(scope="module")
def gait(walker: Rollout) -> Gait:
    return gait_of(walker, Imitation(settle=1.0))


def test_the_clock_says_when_feet_touch_down(walker: Rollout, gait: Gait):
    recording = walker.recording()
    away = np.exp(2j * np.pi * gait.phases(touch_downs(recording, "left")[1:]))
    np.testing.assert_allclose(away, 1.0, atol=0.1)
    np.testing.assert_allclose(gait.phases(touch_downs(recording, "right")[2:]), gait.right, atol=0.03)
    assert gait.right == pytest.approx(0.5, abs=0.02)


def test_the_gait_is_where_its_recording_is(walker: Rollout, gait: Gait):
    recording = walker.recording()
    late = recording.time > 2.0
    rows = (gait.phases(recording.time[late]) * BINS).astype(int)
    for k, name in enumerate(walker.coordinate_names[7:], start=7):
        away = gait.coordinate[rows, k] - recording.coordinate[late, k]
        assert np.sqrt(np.mean(away**2)) < 0.06, name


def test_both_sides_of_an_even_gait_are_each_others_images(walker: Rollout):
    body = BodySymmetry(walker)
    even = gait_of(walker, Imitation(settle=1.0), body)
    later = np.roll(even.coordinate, BINS // 2, axis=0)
    names = walker.coordinate_names
    for name, (other, sign) in body.coordinates.items():
        np.testing.assert_allclose(
            even.coordinate[:, names.index(name)], sign * later[:, names.index(other)], atol=1e-6, err_msg=name
        )


@pytest.mark.parametrize("norm", WALKING)
def test_hips_knees_and_ankles_bend_as_a_norm_says(walker: Rollout, norm):
    gait = gait_of(walker, Imitation(norm=norm.source, settle=1.0))
    percent = PERCENT_OF_BIN - 0.5
    names = walker.coordinate_names
    knee, ankle, hip = (gait.coordinate[:, names.index(name)] for name in ("lKnee", "lAnkle.0", "lHip.qx"))
    np.testing.assert_allclose(np.degrees(knee), norm.angles["Knee flexion"].mean(percent), atol=1e-6)
    np.testing.assert_allclose(np.degrees(-ankle), norm.angles["Ankle dorsiflexion"].mean(percent), atol=1e-6)
    w = gait.coordinate[:, names.index("lHip.qw")]
    np.testing.assert_allclose(-2 * np.degrees(np.arctan2(hip, w)), norm.angles["Hip flexion"].mean(percent), atol=1e-6)


@pytest.mark.long
def test_what_is_earned_is_the_mean_closeness_of_joints(batch: EpisodeBatch):
    batch.reset(1)
    phases = batch.episodes.phase.numpy().copy()
    assert len(set(phases.round(3))) > 5
    for _ in range(3):
        batch.step()
    np.testing.assert_allclose(batch.episodes.phase.numpy(), (phases + 0.03 * batch._rules.cycle_rate) % 1.0, atol=1e-5)
    table, q = batch.judge._rules.gait, batch.rollout.state.coordinates.numpy().astype(float)
    rows = (batch.episodes.phase.numpy() * BINS).astype(int)
    wanted = table.coordinate.numpy()[rows].astype(float)
    w, x, y, z = q[:, 6], q[:, 3], q[:, 4], q[:, 5]
    up = np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], axis=1)
    total = table.up_weight * np.exp(-np.sum((up - table.up.numpy()[rows]) ** 2, axis=1) / 0.09)
    for first, end, weight in zip(table.first.numpy(), table.end.numpy(), table.weight.numpy(), strict=True):
        one, other = q[:, first:end], wanted[:, first:end]
        away = np.sum((one - other) ** 2, axis=1)
        if end - first == 4:
            away = 4.0 * (1.0 - np.sum(one * other, axis=1) ** 2)
        total += weight * np.exp(-away / 0.09)
    before = batch.judge.gains.sums.numpy()[:, IMITATION].copy()
    earned = batch.judge.gains.reward.numpy() / batch.dt
    np.testing.assert_allclose(earned, total, rtol=1e-4)
    assert before.min() > 2.0 * batch.dt  # as the controller's own gait is near


def test_the_clock_is_sine_and_cosine_of_the_phase(batch: EpisodeBatch):
    batch.reset(2)
    batch.step()
    seen = dict(zip(batch.senses.names, batch.senses.observation.numpy().T, strict=True))
    angle = 2.0 * np.pi * batch.episodes.phase.numpy()
    np.testing.assert_allclose(seen["clock.sin"], np.sin(angle), atol=1e-5)
    np.testing.assert_allclose(seen["clock.cos"], np.cos(angle), atol=1e-5)


@pytest.mark.parametrize(
    ("imitation", "key", "message"),
    [
        (Imitation(norm="Winter"), "learning.imitation.norm", "no norm is called"),
        (Imitation(weights={"lElbo": 1.0}), "learning.imitation.weights.lElbo", "did you mean 'lElbow'"),
        (Imitation(weights={"lElbow": -1.0}), "learning.imitation.weights.lElbow", "must not be negative"),
        (Imitation(cycle_time=0.0), "learning.imitation.cycle_time", "greater than 0"),
    ],
)
def test_impossible_gaits_are_refused(imitation: Imitation, key: str, message: str):
    with pytest.raises(SceneError, match=message) as caught:
        EpisodeBatch(SCENE, 1, "cpu", Task(imitation=imitation))
    assert caught.value.key == key


def test_a_body_without_a_controller_has_no_gait():
    with pytest.raises(SceneError, match="no controller") as caught:
        EpisodeBatch("throw18", 1, "cpu", Task(imitation=Imitation()))
    assert caught.value.key == "learning.imitation"


def test_a_gait_that_falls_at_once_cannot_be_imitated():
    walker = load(SCENE)
    falls = msgspec.structs.replace(walker, failure=msgspec.structs.replace(walker.failure, com_height=1.2))
    with pytest.raises(SceneError, match="no two whole cycles"):
        EpisodeBatch(falls, 1, "cpu", Task(imitation=Imitation()))
