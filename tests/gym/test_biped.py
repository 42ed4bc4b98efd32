"""Environments are what Gymnasium takes for one: its checkers, its reset modes, its random seeds."""

import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

from muscle_arm import leg
from warpmuscle.core.errors import Error
from warpmuscle.core.shipped import shipped_scenes
from warpmuscle.gym import biped as environment
from warpmuscle.gym.biped import BipedEnv, BipedVectorEnv
from warpmuscle.scene import Actuation, Scene

pytestmark = pytest.mark.usefixtures("unoptimized_kernels")

STEPS = 10  # of the environment an episode


def scene(muscles: bool = True) -> Scene:
    """A leg that lives for ten steps of an environment, driven by muscles, or by torques with a free root."""
    given = leg(duration=STEPS * 0.005)
    for muscle in given.character.muscles.values():
        muscle.delay = 0.01  # which a batch for pictures has to bear
    if not muscles:
        given.actuation = {"hip": Actuation("torque"), "knee": Actuation("torque")}
        given.character.muscles, given.character.root_joint = {}, "free"
        given.ground.stiffness, given.failure.com_height = 0.0, 0.99
    return given


def vector(count: int = 3, muscles: bool = True, **settings) -> BipedVectorEnv:
    return BipedVectorEnv(count, scene(muscles), "cpu", frame_skip=10, **settings)


@pytest.mark.parametrize("muscles", [True, False])
def test_the_single_environment_passes_gymnasiums_checker_without_a_warning(muscles: bool):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*env.spec.*")  # which only environments made by name have
        check_env(BipedEnv(scene(muscles), "cpu", frame_skip=10), skip_render_check=True)


def test_both_are_made_by_name():
    one = gymnasium.make("warpmuscle/Biped-v0", scene=scene(), device="cpu")
    assert isinstance(one.unwrapped, BipedEnv)
    many = gymnasium.make_vec("warpmuscle/Biped-v0", num_envs=4, scene=scene(), device="cpu")
    assert isinstance(many.unwrapped, BipedVectorEnv)
    assert many.unwrapped.metadata["autoreset_mode"] == AutoresetMode.SAME_STEP
    many = gymnasium.wrappers.vector.RecordEpisodeStatistics(many)
    observed, _ = many.reset(seed=1)
    assert many.observation_space.contains(observed)
    observed, reward, terminated, truncated, _ = many.step(many.action_space.sample())
    assert many.observation_space.contains(observed)
    assert (reward.shape, terminated.dtype, truncated.dtype) == ((4,), bool, bool)


def test_many_are_what_gymnasium_makes_of_single_ones_in_the_same_mode():
    """But for the noise at the start, which is one stream for all of them."""
    many = vector(3, velocity_noise=0.0)
    singles = gymnasium.vector.SyncVectorEnv(
        [lambda: BipedEnv(scene(), "cpu", frame_skip=10, velocity_noise=0.0)] * 3,
        autoreset_mode=AutoresetMode.SAME_STEP,
    )
    assert many.observation_space == singles.observation_space
    assert many.action_space == singles.action_space
    np.testing.assert_array_equal(many.reset(seed=1)[0], singles.reset(seed=1)[0])
    actions = np.random.default_rng(1).uniform(-1.0, 1.0, (STEPS + 2, 3, 3)).astype(np.float32)
    for step, action in enumerate(actions):
        ours, theirs = many.step(action), singles.step(action)
        for one, other in zip(ours[:4], theirs[:4], strict=True):
            np.testing.assert_allclose(one, other, atol=1e-7)
        assert ("final_obs" in ours[4]) == ("final_obs" in theirs[4]) == (step == STEPS - 1)
        if step == STEPS - 1:
            for one, other in zip(ours[4]["final_obs"], theirs[4]["final_obs"], strict=True):
                np.testing.assert_array_equal(one, other)


def test_seeds_give_the_same_episodes_and_no_seed_others():
    env = vector(3, muscles=False, velocity_noise=0.1)
    first, again = env.reset(seed=5)[0], env.reset(seed=5)[0]
    other = env.reset()[0]
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
    assert not np.array_equal(first[0], first[1])


def test_what_falls_is_terminated_and_starts_again_at_once():
    env = vector(2, muscles=False, velocity_noise=0.0)
    first, _ = env.reset(seed=1)
    ended = np.zeros(2, dtype=bool)
    for _ in range(STEPS):
        observed, reward, terminated, truncated, info = env.step(np.zeros(env.action_space.shape, dtype=np.float32))
        ended |= terminated
        assert not (terminated & truncated).any()
        if terminated.any():
            np.testing.assert_array_equal(observed[terminated], first[terminated])
            assert info["final_info"]["status"].tolist() == [2, 2]
            assert (reward[terminated] < 0.9 * env.bipeds.dt).all()
            break
    assert ended.all()


def test_the_reward_is_distance_and_life_less_effort_or_the_objective():
    actions = np.full((2, 3), 0.5, dtype=np.float32)
    env = vector(2)
    env.reset(seed=1)
    reward = env.step(actions)[1]
    np.testing.assert_allclose(reward, env.bipeds.dt * (1.0 - 0.5 * 0.75**2), rtol=1e-5)
    given = scene()
    given.objective.effort_squared = 3.0
    env = BipedVectorEnv(
        2, given, "cpu", frame_skip=10, speed_weight=0.0, alive_weight=0.0, effort_weight=0.0, objective_weight=1.0
    )
    env.reset(seed=1)
    rewards = sum(env.step(actions)[1] for _ in range(3))
    np.testing.assert_allclose(rewards, -env.bipeds.rollout.cost(), rtol=1e-5)


def test_actions_that_are_no_numbers_leave_observations_finite():
    env = vector(2)
    env.reset(seed=1)
    observed, reward, *_ = env.step(np.full((2, 3), np.nan, dtype=np.float32))
    assert np.isfinite(observed).all()
    assert np.isfinite(reward).all()


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"frame_skp": 3}, "there is no setting 'frame_skp'; did you mean 'frame_skip'"),
        ({"frame_skip": 0.5}, "frame_skip must be a positive whole number"),
        ({"speed_weight": np.nan}, "speed_weight must be a finite number"),
        ({"torque_limit": 0}, "torque_limit must be positive"),
    ],
)
def test_impossible_settings_are_refused_in_one_line(settings: dict, message: str):
    with pytest.raises(Error, match=message):
        BipedEnv(scene(), "cpu", **settings)
    assert environment.Settings.of({}).frame_skip == 20


def test_a_name_with_its_module_needs_no_import_of_ours():
    name = "warpmuscle.gym:warpmuscle/Biped-v0"
    code = f"import gymnasium; gymnasium.make({name!r}, scene='no such scene')"
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False).stderr
    assert "there is no scene called 'no such scene'" in said


def test_each_shipped_scene_is_an_environment_by_its_name():
    specs = {name: gymnasium.spec(f"warpmuscle/{name}-v0") for name in shipped_scenes()}
    assert len(specs) > 40
    assert all(spec.kwargs == {"scene": name} for name, spec in specs.items())
    assert all(spec.entry_point == gymnasium.spec("warpmuscle/Biped-v0").entry_point for spec in specs.values())


def test_pictures_show_the_body_as_it_stands_and_films_are_made_of_them():
    pytest.importorskip("matplotlib")
    env = gymnasium.make("warpmuscle/Biped-v0", scene=scene(), device="cpu", frame_skip=10, render_mode="rgb_array")
    env.reset(seed=1)
    first = env.render()
    assert first.shape == (480, 640, 3)
    assert first.dtype == np.uint8
    assert len(np.unique(first.reshape(-1, 3), axis=0)) > 50  # a body, shaded, on ground
    for _ in range(5):
        env.step(np.ones(3, dtype=np.float32))
    assert (env.render() != first).any()
    assert env.metadata["render_fps"] == 200
    many = BipedVectorEnv(2, scene(), "cpu", frame_skip=10, render_mode="rgb_array")
    many.reset(seed=1)
    assert many.render()[0].shape == many.call("render")[0].shape == (480, 640, 3)
    assert many.call("num_envs") == (2, 2)
    assert vector().call("render") == ()
    assert vector().render() is None
    with pytest.raises(Error, match="there is no render_mode 'human'; known: rgb_array"):
        BipedEnv(scene(), "cpu", render_mode="human")


def test_a_body_beyond_all_bounds_is_drawn_as_it_was():
    env = BipedEnv(scene(), "cpu", frame_skip=10, render_mode="rgb_array")
    env.reset(seed=1)
    before = env.render()
    coordinates = env.bipeds.rollout.state.coordinates
    coordinates.fill_(np.nan)
    assert np.array_equal(env.render(), before)
