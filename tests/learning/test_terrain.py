"""Learning on ground that is not flat: starts over it, heights above it, and variants from easy to hard."""

import msgspec
import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

from warpmuscle.core.errors import SceneError
from warpmuscle.formats import load
from warpmuscle.kernels.learning import episodes as kernels
from warpmuscle.learning import EpisodeBatch, Sense, Task, Variation
from warpmuscle.learning.player import commanded
from warpmuscle.learning.variants import drawn_commands
from warpmuscle.scene import Command, Ground, Scene, Terrain
from warpmuscle.scene.number import Free
from warpmuscle.scene.terrain.surface import surface
from warpmuscle.scene.terrain.tiles import Profile, Rough
from warpmuscle.scene.validation.scene import check_scene

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

HIGH = 0.5
PLATEAU = Terrain([Profile([(-1.0, HIGH), (1.0, HIGH)])])


def on(terrain: Terrain | None, **commands: Command) -> Scene:
    scene = msgspec.structs.replace(load("reflex_planar"), duration=0.8, commands=commands)
    return msgspec.structs.replace(scene, ground=msgspec.structs.replace(scene.ground, terrain=terrain))


def test_on_a_plateau_episodes_start_higher_and_observe_the_same():
    """Starts of the gait included: they are recorded on the plateau, and put back over it."""
    variation = Variation(velocity_noise=0.0, start_states=3, start_after=0.5)
    task = Task(variation=variation, episode_time=0.02)
    plain, high = (EpisodeBatch(on(terrain), 12, "cpu", task, threads=1) for terrain in (None, PLATEAU))
    rows = plain.episodes.start_row.numpy()
    assert set(rows) == {0, 1, 2}
    np.testing.assert_array_equal(rows, high.episodes.start_row.numpy())
    below, above = (one.rollout.state.coordinates.numpy() for one in (plain, high))
    np.testing.assert_allclose(above[:, 0] - below[:, 0], HIGH, atol=1e-3)
    np.testing.assert_allclose(above[:, 1:], below[:, 1:], atol=5e-3)  # half a second of walking in single precision
    observed = [one.senses.observation.numpy() for one in (plain, high)]
    assert np.abs(observed[0] - observed[1]).max() < 0.05


def test_each_episode_starts_over_the_ground_of_its_variant():
    bumps = Command(0.0, 0.0, 0.1, unit="m")
    scene = on(Terrain([Rough(height=1.0, seed=2)], scale=Free(0.0, per={"bumps": 1.0})), bumps=bumps)
    variation = Variation(velocity_noise=0.0, commands=["bumps"], variants=40)
    batch = EpisodeBatch(scene, 16, "cpu", Task(variation=variation, episode_time=0.05), threads=1)
    scale = drawn_commands(variation, scene, 40)["bumps"][batch.episodes.variant.numpy()]
    assert scale.max() > 0.05 > scale.min()
    plain = EpisodeBatch(on(None), 1, "cpu", Task(variation=Variation(velocity_noise=0.0)), threads=1)
    height, z = plain.rollout.state.coordinates.numpy()[0, :2]
    whole = surface(on(Terrain([Rough(height=1.0, seed=2)])).ground).highest_rise(0.0, float(z), 0.25)
    raised = batch.rollout.state.coordinates.numpy()[:, 0] - height
    np.testing.assert_allclose(raised, scale * whole, atol=1e-5)


def test_variants_that_are_graded_come_from_easy_to_hard():
    commands = {"bumps": Command(0.02, 0.0, 0.1), "place": Command(0.0, 0.0, 8.0)}
    variation = Variation(commands=["bumps", "place"], graded="bumps")
    found = drawn_commands(variation, on(None, **commands), 200)
    away = np.abs(found["bumps"] - 0.02)
    assert (np.diff(away) >= 0.0).all()
    plain = drawn_commands(msgspec.structs.replace(variation, graded=""), on(None, **commands), 200)
    pairs, sorted_pairs = (set(zip(one["bumps"], one["place"], strict=True)) for one in (plain, found))
    assert pairs == sorted_pairs


def test_an_episode_has_one_of_the_share_of_variants_that_it_is_difficult():
    n, variants = 4000, 50
    rules, episodes = kernels.EpisodeRules(), kernels.Episodes()
    rules.variants = variants
    difficulty = np.repeat([0.0, 0.1, 0.5, 1.0], n // 4).astype(np.float32)
    mask = np.arange(n) % 5 > 0
    episodes.seed = wp.array([3], dtype=int, device="cpu")
    episodes.number = wp.full(n, 7, dtype=int, device="cpu")
    episodes.variant = wp.full(n, -1, dtype=int, device="cpu")
    episodes.mask = wp.array(mask, dtype=bool, device="cpu")
    wp.launch(kernels.grade_variants, n, [rules, wp.array(difficulty, device="cpu"), episodes], device="cpu")
    variant = episodes.variant.numpy()
    assert (variant[~mask] == -1).all()
    for share, count in ((0.0, 1), (0.1, 5), (0.5, 25), (1.0, 50)):
        drawn = variant[mask & (difficulty == np.float32(share))]
        assert set(drawn) == set(range(count))


def test_hard_episodes_may_do_without_the_easiest_variants():
    n, variants = 3000, 50
    rules, episodes = kernels.EpisodeRules(), kernels.Episodes()
    rules.variants, rules.left_out = variants, 0.7  # as of graded_share 0.3
    difficulty = np.repeat([0.0, 0.2, 0.5, 1.0], n // 4).astype(np.float32)
    episodes.seed = wp.array([3], dtype=int, device="cpu")
    episodes.number = wp.full(n, 7, dtype=int, device="cpu")
    episodes.variant = wp.full(n, -1, dtype=int, device="cpu")
    episodes.mask = wp.full(n, True, dtype=bool, device="cpu")
    wp.launch(kernels.grade_variants, n, [rules, wp.array(difficulty, device="cpu"), episodes], device="cpu")
    variant = episodes.variant.numpy()
    for share, first, count in ((0.0, 0, 1), (0.2, 0, 10), (0.5, 10, 25), (1.0, 35, 50)):
        assert set(variant[difficulty == np.float32(share)]) == set(range(first, count))


@pytest.mark.parametrize("share", [0.0, 1.1, -0.3, float("nan")])
def test_a_share_of_graded_variants_is_some_and_not_more_than_all(share: float):
    scene = msgspec.structs.replace(on(None), learning=Task(variation=Variation(graded_share=share)))
    with pytest.raises(SceneError) as error:
        check_scene(scene)
    assert error.value.key == "learning.variation.graded_share"


@pytest.mark.parametrize(
    ("task", "words"),
    [
        (Task(curriculum="a:b", variation=Variation(graded="bumps")), "no command of learning.variation.commands"),
        (Task(variation=Variation(commands=["bumps"], graded="bumps")), "learning.curriculum makes"),
    ],
)
def test_grades_need_a_command_that_is_drawn_and_a_curriculum(task: Task, words: str):
    scene = msgspec.structs.replace(on(None, bumps=Command(0.0, 0.0, 0.1)), learning=task)
    with pytest.raises(SceneError, match=words) as error:
        check_scene(scene)
    assert error.value.key == "learning.variation.graded"


def test_a_policy_sees_the_ground_ahead_and_behind_as_it_faces():
    steps = Terrain([Rough(height=0.2, spacing=0.3, seed=4)], x=0.3)
    scene = msgspec.structs.replace(load("fwalk"), ground=Ground(normal=(0.1, 1.0, -0.1), terrain=steps))
    task = Task(
        observations={"ground": Sense(), "ground_behind": Sense()},
        actions="torques",
        variation=Variation(velocity_noise=0.0),
    )
    batch = EpisodeBatch(scene, 1, "cpu", task, threads=1)
    q = batch.rollout.state.coordinates.numpy().copy()
    q[0, :7] = [0.7, 1.0, -0.4, *Rotation.from_euler("YX", [0.8, 0.2]).as_quat()]
    batch.rollout.state.coordinates.assign(q)
    batch.senses.sample_first(batch.rollout.state, batch.episodes)
    batch.observe_again()
    seen = dict(zip(batch.senses.names, batch.senses.observation.numpy()[0], strict=True))
    ground = surface(scene.ground)
    here = ground.height_at(0.7, -0.4)
    names = []
    for group, row in [*(("ground", row) for row in range(1, 7)), *(("ground_behind", row) for row in (-2, -1, 0))]:
        for side, across in (("right", -0.2), ("middle", 0.0), ("left", 0.2)):
            if row == 0 and side == "middle":  # below the root
                continue
            names.append(f"{group}.{side}.{row}")
            way = Rotation.from_euler("Y", 0.8).apply([across, 0.0, 0.2 * row])
            expected = 10.0 * (ground.height_at(0.7 + way[0], -0.4 + way[2]) - here)
            assert seen[names[-1]] == pytest.approx(expected, abs=2e-4)
    assert list(seen) == names


def test_a_share_of_what_is_drawn_turns_and_the_rest_goes_straight_on():
    task = Task(
        speed=(0.5, 1.5),
        turning_rate=(0.2, 0.4),
        turning_share=0.25,
        actions="torques",
        variation=Variation(velocity_noise=0.0),
    )
    every = msgspec.structs.replace(task, turning_share=1.0)
    some, all_ = (EpisodeBatch("fwalk", 2000, "cpu", one, threads=1).episodes.command.numpy() for one in (task, every))
    turns = some[:, 1] != 0.0
    assert turns.mean() == pytest.approx(0.25, abs=0.04)
    np.testing.assert_array_equal(some[:, 0], all_[:, 0])
    np.testing.assert_array_equal(some[turns], all_[turns])
    assert (all_[:, 1] >= 0.2).all()


@pytest.mark.parametrize("share", [-0.1, 1.1, float("nan")])
def test_a_share_that_is_none_is_refused(share: float):
    scene = msgspec.structs.replace(load("fwalk"), learning=Task(turning_share=share))
    with pytest.raises(SceneError) as error:
        check_scene(scene)
    assert error.value.key == "learning.turning_share"


def test_a_turn_that_is_told_is_made_whatever_share_was_drawn():
    told = commanded(Task(turning_rate=(-0.5, 0.5), turning_share=0.2), ["turning_rate=0.3"])
    assert (told.turning_rate, told.turning_share) == ((0.3, 0.3), 1.0)


STAIRS = Terrain([Profile([(0.5, 0.0), (0.52, 0.17), (0.83, 0.17), (0.85, 0.34)])], z=-0.2)


def test_a_policy_sees_how_high_strips_of_the_feet_s_ways_are():
    """Means over 10 cm tell where within a strip an edge is."""
    scene = msgspec.structs.replace(load("fwalk"), ground=Ground(normal=(0.0, 1.0, 0.0), terrain=STAIRS))
    task = Task(observations={"footing": Sense()}, actions="torques", variation=Variation(velocity_noise=0.0))
    batch = EpisodeBatch(scene, 1, "cpu", task, threads=1)
    q = batch.rollout.state.coordinates.numpy().copy()
    q[0, :7] = [0.7, 1.0, 0.013, *Rotation.from_euler("Y", 0.4).as_quat()]
    batch.rollout.state.coordinates.assign(q)
    batch.senses.sample_first(batch.rollout.state, batch.episodes)
    batch.observe_again()
    seen = dict(zip(batch.senses.names, batch.senses.observation.numpy()[0], strict=True))
    ground = surface(scene.ground)
    assert len(seen) == 24
    for row in range(-3, 9):
        for side, across in (("right", -0.1), ("left", 0.1)):
            ways = [[across, 0.0, 0.1 * row + part] for part in (-0.0375, -0.0125, 0.0125, 0.0375)]
            places = Rotation.from_euler("Y", 0.4).apply(ways) + np.array([0.7, 0.0, 0.013])
            expected = np.mean([ground.height_at(x, z) for x, _, z in places]) - ground.height_at(0.7, 0.013)
            assert seen[f"footing.{side}.{row}"] == pytest.approx(10.0 * expected, abs=2e-4)
    assert len({round(float(value), 3) for value in seen.values()}) > 4


def test_the_image_of_the_ground_is_what_the_image_of_a_body_sees():
    """Stairs across z are their own image."""
    scene = msgspec.structs.replace(load("fwalk"), ground=Ground(normal=(0.0, 1.0, 0.0), terrain=STAIRS))
    task = Task(
        observations={"ground": Sense(), "ground_behind": Sense(), "footing": Sense()},
        actions="torques",
        variation=Variation(velocity_noise=0.0),
        symmetric=True,
    )
    batch = EpisodeBatch(scene, 2, "cpu", task, threads=1)
    q = batch.rollout.state.coordinates.numpy().copy()
    for row, side in enumerate((1.0, -1.0)):
        q[row, :7] = [0.7 * side, 1.0, 0.013, *Rotation.from_euler("Y", 0.8 * side).as_quat()]
    batch.rollout.state.coordinates.assign(q)
    batch.senses.sample_first(batch.rollout.state, batch.episodes)
    batch.observe_again()
    seen = batch.senses.observation.numpy()
    assert batch.images is not None
    np.testing.assert_allclose(batch.images.observation.of(seen[0]), seen[1], atol=1e-4)
    assert np.abs(seen[0] - seen[1]).max() > 0.5
