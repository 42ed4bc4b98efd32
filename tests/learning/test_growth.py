"""Disturbances that grow with the episodes that an instance lasts."""

import msgspec
import numpy as np
import pytest
import warp as wp

from warpmuscle.core.errors import RolloutError, SceneError
from warpmuscle.formats import load
from warpmuscle.kernels.learning.episodes import NOT_YET, quarter_of
from warpmuscle.learning import EpisodeBatch, Task, Variation
from warpmuscle.learning.player import in_full
from warpmuscle.scene.learning import Imitation
from warpmuscle.scene.learning.task import GROWING
from warpmuscle.scene.validation.scene import check_scene

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")
EPISODE = 0.2  # s, in which nothing falls


def batch_of(variation, episode_time=EPISODE, com_height=None, **task):
    scene = load("reflex_planar")
    if com_height is not None:
        scene.failure = msgspec.structs.replace(scene.failure, com_height=com_height)
    task = Task(variation=variation, episode_time=episode_time, **task)
    return EpisodeBatch(scene, 4, "cpu", task, seed=3, threads=1)


def hardness(batch):
    return batch.episodes.hardness.numpy()


def after(batch, decisions):
    for _ in range(decisions):
        batch.step()
    return hardness(batch)


def test_hardness_grows_with_every_episode_that_lasts_until_it_is_whole():
    batch = batch_of(Variation(velocity_noise=0.0, growth=0.4))
    np.testing.assert_array_equal(hardness(batch), 0.0)
    for expected in (0.4, 0.8, 1.0, 1.0):
        np.testing.assert_allclose(after(batch, batch.longest), expected)


def test_it_shrinks_as_much_with_every_episode_that_fails_and_never_below_nothing():
    batch = batch_of(Variation(velocity_noise=0.0, growth=0.4), episode_time=1.0, com_height=1.5)  # fails at once
    batch.episodes.hardness.fill_(1.0)
    for expected in (0.6, 0.2, 0.0, 0.0):
        np.testing.assert_allclose(after(batch, 1), expected, atol=1e-6)
    batch = batch_of(Variation(velocity_noise=0.0), episode_time=1.0, com_height=1.5)
    np.testing.assert_array_equal(after(batch, 2), 1.0)  # without growth all is there all the time


@pytest.mark.parametrize(("lasting", "lost"), [(0.0, 0.0), (0.5, 0.1), (0.75, 0.3), (0.9, 0.9)])
def test_where_a_share_of_episodes_lasts_hardness_stays(lasting, lost):
    """lasting * growth = (1 - lasting) * what a failure takes off."""
    variation = Variation(velocity_noise=0.0, growth=0.1, lasting=lasting)
    batch = batch_of(variation, episode_time=1.0, com_height=1.5)  # fails at once
    batch.episodes.hardness.fill_(1.0)
    np.testing.assert_allclose(after(batch, 1), 1.0 - lost, atol=1e-6)


def test_a_reset_is_no_failure_and_begins_from_nothing_where_a_seed_is_given():
    batch = batch_of(Variation(velocity_noise=0.0, growth=0.4))
    after(batch, batch.longest + 3)
    batch.reset()
    np.testing.assert_allclose(hardness(batch), 0.4)
    batch.reset(1)
    np.testing.assert_array_equal(hardness(batch), 0.0)


def test_pushes_and_noise_at_the_start_are_the_share_of_those_in_full():
    variation = Variation(velocity_noise=0.3, push=20.0, push_interval=0.05)
    full, half = batch_of(variation), batch_of(msgspec.structs.replace(variation, growth=0.5))
    still = batch_of(Variation(velocity_noise=0.0))
    half.episodes.hardness.fill_(0.5)
    half.episodes.mask.fill_(True)
    for batch in (full, half, still):  # the same numbers of the same episodes
        batch.episodes.number.zero_()
        batch.episodes.decision.zero_()
        batch.begin(np.ones(4, dtype=bool))
    begun = [batch.rollout.state.speeds.numpy()[:, :2].copy() for batch in (full, half, still)]
    assert np.abs(begun[0] - begun[2]).min() > 0.0
    np.testing.assert_allclose(begun[1] - begun[2], 0.5 * (begun[0] - begun[2]), rtol=1e-5, atol=1e-6)
    pushed = []
    for batch in (full, half):
        after(batch, 10)
        pushed.append(batch.rollout.state.push.numpy().copy())
    assert (np.linalg.norm(pushed[0], axis=1) > 0.0).all()
    np.testing.assert_allclose(pushed[1], 0.5 * pushed[0], rtol=1e-6)


@pytest.mark.parametrize(("share", "latest"), [(0.0, 0), (0.5, 2), (1.0, 4)])
def test_nerves_are_late_and_noisy_by_their_share(share, latest):
    variation = Variation(velocity_noise=0.0, delay=0.04, noise=0.1, growth=0.5)
    batch = batch_of(variation, observations={"trunk": {}, "trunk_speed": {}})
    late, noisy = [], []
    names = list(batch.senses.critic_names)
    for _ in range(40):
        batch.begin(np.ones(4, dtype=bool))
        batch.episodes.hardness.fill_(share)
        batch.senses.observe_critic(batch.rollout.state, batch.episodes)
        seen = batch.senses.critic.numpy()
        late += list(seen[:, next(k for k, name in enumerate(names) if "delay" in name)])
        noisy += list(seen[:, next(k for k, name in enumerate(names) if name.endswith("noise"))])
    assert sorted({round(4.0 * part) for part in late}) == list(range(latest + 1))  # told as a share of the latest
    print(max(noisy))
    assert max(noisy) <= share
    assert max(noisy) >= 0.9 * share


@pytest.mark.parametrize("name", GROWING)
def test_what_does_not_grow_is_there_from_the_start(name):
    """Of each disturbance: in full if it is not among those that grow, else not at all at first."""
    variation = Variation(velocity_noise=0.3, push=20.0, push_interval=0.05, delay=0.04, noise=0.1, growth=0.5)
    others = [other for other in GROWING if other != name]
    batch = batch_of(
        msgspec.structs.replace(variation, growing=tuple(others)), observations={"trunk": {}, "trunk_speed": {}}
    )
    still = batch_of(Variation(velocity_noise=0.0), observations={"trunk": {}, "trunk_speed": {}})
    names, late, noisy = list(batch.senses.critic_names), 0.0, 0.0
    for _ in range(10):
        batch.begin(np.ones(4, dtype=bool))
        batch.senses.observe_critic(batch.rollout.state, batch.episodes)
        seen = batch.senses.critic.numpy()
        late = max(late, *(seen[:, k].max() for k, text in enumerate(names) if "delay" in text))
        noisy = max(noisy, *(seen[:, k].max() for k, text in enumerate(names) if text.endswith("noise")))
    fast = np.abs(batch.rollout.state.speeds.numpy()[:, 0] - still.rollout.state.speeds.numpy()[:, 0]).max()
    after(batch, 10)
    pushed = np.linalg.norm(batch.rollout.state.push.numpy(), axis=1).max()
    found = {"velocity_noise": fast > 0.0, "push": pushed > 0.0, "delay": late > 0.0, "noise": noisy > 0.0}
    assert found == {other: other == name for other in GROWING}


def test_trials_of_a_policy_have_all_of_it():
    task = Task(variation=Variation(push=30.0, growth=0.1))
    assert in_full(task).variation == Variation(push=30.0)
    assert in_full(None) is None
    plain = Task(variation=Variation(push=30.0))
    assert in_full(plain) is plain


def test_what_cannot_be_is_refused():
    scene = load("reflex_planar")
    scene.learning = Task(variation=Variation(growth=1.5))
    with pytest.raises(SceneError, match="within 0 and 1") as error:
        check_scene(scene)
    assert error.value.key == "learning.variation.growth"
    scene.learning = Task(variation=Variation(growth=0.1, lasting=1.0))
    with pytest.raises(SceneError, match="less than 1") as error:
        check_scene(scene)
    assert error.value.key == "learning.variation.lasting"
    scene.learning = Task(variation=Variation(growth=0.1, growing=("pushes",)))
    with pytest.raises(SceneError, match="did you mean 'push'") as error:
        check_scene(scene)
    assert error.value.key == "learning.variation.growing"
    batch = batch_of(Variation(growth=0.5))
    batch.episodes.hardness.fill_(np.nan)
    with pytest.raises(RolloutError, match="hardness"):
        batch.check_state()


AHEAD, LEFT, BACK, RIGHT = range(4)
PUSHED = Variation(velocity_noise=0.0, push=8.0, push_interval=0.04, push_growth=0.25, lasting=0.6)


def test_a_direction_lies_in_the_nearest_quarter():
    angles = np.radians([0.0, 44.0, 46.0, 90.0, 134.0, 136.0, 224.0, 226.0, 314.0, 316.0, 359.9])
    found = wp.zeros(len(angles), dtype=int, device="cpu")

    @wp.kernel
    def quarters(angle: wp.array[float], found: wp.array[int]):
        found[wp.tid()] = quarter_of(angle[wp.tid()])

    wp.launch(quarters, len(angles), [wp.array(angles, dtype=float, device="cpu"), found], device="cpu")
    expected = [AHEAD, AHEAD, LEFT, LEFT, LEFT, BACK, BACK, RIGHT, RIGHT, AHEAD, AHEAD]
    np.testing.assert_array_equal(found.numpy(), expected)


def test_pushes_to_a_side_grow_with_those_that_are_withstood_there():
    """By what comes of every push: it is counted when the next one comes, in its own direction alone."""
    batch = batch_of(PUSHED, episode_time=10.0)
    expected, seen = np.zeros((4, 4)), 0
    for _ in range(60):
        before, waiting = batch.episodes.pushed.numpy().copy(), batch.episodes.next_push.numpy().copy()
        batch.step()
        comes = batch.episodes.decision.numpy() >= waiting
        for i in np.flatnonzero(comes & (before >= 0)):
            expected[i, before[i]] = min(expected[i, before[i]] + 0.25, 1.0)
            seen += 1
        np.testing.assert_allclose(batch.episodes.push_hardness.numpy(), expected)
    assert seen > 8
    assert (expected > 0.0).any(axis=0).all()
    np.testing.assert_array_equal(hardness(batch), 1.0)  # of all else, which does not grow


@pytest.mark.parametrize(("episode_time", "change"), [(0.02, 0.25), (1.0, -0.375)])
def test_the_last_push_is_withstood_if_the_episode_lasts_and_not_if_it_fails(episode_time, change):
    """0.6 of them where hardness stays: 0.6 * 0.25 = 0.4 * 0.375."""
    com_height = 1.5 if change < 0.0 else None  # fails at once
    variation = msgspec.structs.replace(PUSHED, push_interval=50.0)
    batch = batch_of(variation, episode_time=episode_time, com_height=com_height)
    batch.episodes.push_hardness.fill_(0.5)
    batch.episodes.pushed.assign(np.array([AHEAD, RIGHT, NOT_YET, LEFT], dtype=np.int32))
    after(batch, batch.longest if change > 0.0 else 1)
    expected = np.full((4, 4), 0.5)
    for i, quarter in ((0, AHEAD), (1, RIGHT), (3, LEFT)):
        expected[i, quarter] += change
    np.testing.assert_allclose(batch.episodes.push_hardness.numpy(), expected, atol=1e-6)
    np.testing.assert_array_equal(batch.episodes.pushed.numpy(), NOT_YET)


def test_pushes_go_where_they_are_counted_and_are_as_hard_as_it_is_there():
    """Along the wanted heading, from the least share to all of the greatest impulse that there is to that side."""
    variation = msgspec.structs.replace(PUSHED, push_least=0.5, push_growth=1e-6, push_duration=0.01)
    batch, heading = batch_of(variation, episode_time=20.0), 0.6
    batch.episodes.heading.fill_(heading)
    hard = np.array([1.0, 0.5, 0.25, 0.1])
    batch.episodes.push_hardness.assign(np.tile(hard, (4, 1)))
    shares = []
    for _ in range(120):
        waiting = batch.episodes.next_push.numpy().copy()
        batch.step(restart=False)
        for i in np.flatnonzero(batch.episodes.decision.numpy() >= waiting):
            x, _, z = batch.rollout.state.push.numpy()[i] * 0.01  # N s
            angle = (np.arctan2(x, z) - heading) % (2.0 * np.pi)
            quarter = round(angle / (0.5 * np.pi)) % 4
            assert batch.episodes.pushed.numpy()[i] == quarter
            shares.append(np.hypot(x, z) / (8.0 * hard[quarter]))
    assert 0.5 <= min(shares) < 0.6
    assert 0.9 < max(shares) <= 1.0 + 1e-4


def test_a_reset_with_a_seed_begins_without_pushes_and_trials_have_all_of_them():
    batch = batch_of(PUSHED)
    np.testing.assert_array_equal(batch.episodes.push_hardness.numpy(), 0.0)
    batch.episodes.push_hardness.fill_(0.5)
    batch.reset()
    np.testing.assert_array_equal(batch.episodes.push_hardness.numpy(), 0.5)
    batch.reset(1)
    np.testing.assert_array_equal(batch.episodes.push_hardness.numpy(), 0.0)
    np.testing.assert_array_equal(batch_of(Variation(push=8.0)).episodes.push_hardness.numpy(), 1.0)
    assert in_full(Task(variation=PUSHED)).variation == msgspec.structs.replace(PUSHED, push_growth=0.0)


@pytest.mark.parametrize(("name", "value"), [("push_growth", 1.5), ("push_least", -0.1)])
def test_shares_of_pushes_are_shares(name, value):
    scene = load("reflex_planar")
    scene.learning = Task(variation=msgspec.structs.replace(PUSHED, **{name: value}))
    with pytest.raises(SceneError, match="within 0 and 1") as error:
        check_scene(scene)
    assert error.value.key == f"learning.variation.{name}"


@pytest.mark.parametrize(("array", "value"), [("push_hardness", 1.5), ("pushed", 4), ("pushed", -2)])
def test_a_state_with_pushes_that_cannot_be_is_refused(array, value):
    batch = batch_of(PUSHED)
    getattr(batch.episodes, array).fill_(value)
    with pytest.raises(RolloutError, match=r"hardness|push"):
        batch.check_state()


@pytest.mark.parametrize(
    ("name", "value", "match"),
    [
        ("push_phase", (0.4, 0.3), "lower and an upper"),
        ("push_phase", (0.5, 1.6), "1 apart"),
        ("push_direction", (-400.0, 0.0), "-360 to 360"),
        ("push_phase", (0.3, 0.4), "no clock"),
    ],
)
def test_pushes_are_aimed_within_one_cycle_of_a_gait_and_one_turn(name, value, match):
    scene = load("reflex_planar")
    scene.learning = Task(variation=Variation(push=8.0, **{name: value}))
    with pytest.raises(SceneError, match=match) as error:
        check_scene(scene)
    assert error.value.key == f"learning.variation.{name}"


@pytest.mark.parametrize("symmetric", [False, True])
def test_pushes_of_a_task_begin_in_their_phase_and_half_of_them_mirrored_if_it_is_symmetric(symmetric):
    variation = Variation(
        velocity_noise=0.0, push=1e-3, push_interval=0.02, push_phase=(0.6, 0.7), push_direction=(60.0, 120.0)
    )
    scene = load("walk56")
    scene.learning = Task(variation=variation, imitation=Imitation(), symmetric=symmetric, episode_time=9.0)
    batch = EpisodeBatch(scene, 4, "cpu", scene.learning, seed=3, threads=1)
    found = set()
    for _ in range(100):
        waiting = batch.episodes.next_push.numpy().copy()
        batch.step(restart=False)
        for i in np.flatnonzero(batch.episodes.next_push.numpy() != waiting):
            left = bool(batch.rollout.state.push.numpy()[i, 0] > 0.0)
            found.add(left)
            since = (batch.episodes.phase.numpy()[i] - (0.6 if left else 0.1)) % 1.0
            assert since <= 0.1 + 0.02
    assert found == ({True, False} if symmetric else {True})
