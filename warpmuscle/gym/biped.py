"""Gymnasium environments: many bipeds, or one, that a policy drives by excitations or torques.

    import gymnasium

    envs = gymnasium.make_vec("warpmuscle.gym:warpmuscle/Biped-v0", num_envs=1000, scene="walk56")

Needs `pip install "warpmuscle[gym]"`. With `render_mode="rgb_array"`, which needs the extra `video`, `render` draws the
body as it stands, or of many the first one, and `gymnasium.wrappers.RecordVideo` makes films of it.

Action: numbers in -1..1. Of a scene with muscles their excitations, -1 none and 1 full, and what else drives joints
stays with the scene's controller. Of a scene without, the torques of all joints, 1 being `torque_limit`.

Observation: coordinates without the place on the ground, speeds, foot forces over body weight, and activations of
muscles, float32, within -100..100.

Reward for a step of the environment, which takes dt, unless `objective_weight` says otherwise:

    speed_weight (distance gone forward) + alive_weight dt [not failed] - effort_weight dt (mean of squared effort)

Effort is excitation, or torque over its limit. With an `objective_weight`, that times what the step added to the
scene's weighted objective is taken off as well; so with the other weights at 0 the reward is the objective alone.

An episode is terminated when the biped fails as the scene's `failure` says, and truncated at the scene's duration.

All of this is of a scene without `[learning]`. A scene with one, or a `task` that is given, says itself what actions
do, what is observed, and how late, what is rewarded, how long episodes are and how they begin; then the settings above
mean nothing and are refused, and all numbers are those of `learning.RolloutEnv`, see `tasks`. `task=False` ignores the
scene's `[learning]`. For policies on the GPU use `RolloutEnv`: here arrays pass through NumPy.
"""

from __future__ import annotations

from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from warpmuscle.core.errors import Error
from warpmuscle.core.number_rows import first_number
from warpmuscle.core.status import Status
from warpmuscle.formats import load
from warpmuscle.gym.pictures import Pictures
from warpmuscle.gym.settings import Settings
from warpmuscle.gym.tasks import TaskBatch
from warpmuscle.learning.tasks import checked_task
from warpmuscle.model.objective import weighted
from warpmuscle.scene import Scene
from warpmuscle.scene.joints import root_type
from warpmuscle.scene.learning import Task
from warpmuscle.scene.masses import body_mass
from warpmuscle.simulation.rollout import Rollout

GREATEST = 100.0  # of an observation
MODES = ("rgb_array",)
RESTARTS = (AutoresetMode.SAME_STEP, AutoresetMode.NEXT_STEP)

Array = NDArray[np.float32]
Flags = NDArray[np.bool_]
Step = tuple[Array, Any, Any, Any, dict[str, Any]]


def checked_mode(render_mode: str | None) -> str | None:
    """A way of drawing; raises Error for an unknown one."""
    if render_mode is not None and render_mode not in MODES:
        raise Error(f"there is no render_mode {render_mode!r}; known: {', '.join(MODES)}")
    return render_mode


def checked_restart(mode: str | AutoresetMode) -> AutoresetMode:
    """When episodes begin again; raises Error for a mode that is not offered."""
    for known in RESTARTS:
        if mode in (known, known.value, known.name, known.name.lower()):
            return known
    raise Error(f"there is no autoreset_mode {mode!r} here; known: {', '.join(m.name.lower() for m in RESTARTS)}")


def batch_of(
    count: int,
    scene: str | Scene,
    device: str | None,
    threads: int | None,
    task: Task | Literal[False] | None,
    settings: dict[str, Any],
) -> Bipeds | TaskBatch:
    """The batch of an environment: by the task that is given, or that the scene has, or by settings if there is none.

    Raises:
        SceneError, RolloutError: as `load`, `Rollout` and `EpisodeBatch`.
        Error: an unknown or impossible setting, or one beside a task.
    """
    chosen = Settings.of(settings)
    scene = load(scene) if isinstance(scene, str) else scene
    wanted = None if task is False else checked_task(task) or scene.learning
    if wanted is None:
        return Bipeds(count, scene, device, threads, chosen)
    if settings:
        name = next(iter(settings))
        whose = "the task that is given" if task is not None else f"[learning] of {scene.name}"
        raise Error(f"{name} means nothing here: {whose} says what is done and rewarded; task=False ignores [learning]")
    return TaskBatch(count, scene, device, threads, wanted)


class Bipeds:
    """A batch that acts, and is observed and rewarded by settings, where no task is said."""

    def __init__(self, count: int, scene: Scene, device: str | None, threads: int | None, settings: Settings):
        """Prepare the batch; raises as `Rollout`."""
        self.rollout, self.settings = Rollout(scene, count, device, threads=threads), settings
        rollout, root = self.rollout, root_type(scene.character)
        self.dt = settings.frame_skip * scene.time_step
        self._pictures: Pictures | None = None
        self._weight = body_mass(rollout.numeric.character) * first_number(rollout.numeric.gravity) or 1.0
        self._forward = root.forward
        self._seen = [i for i in range(len(rollout.coordinate_names)) if i not in root.on_ground]
        names = rollout.muscle_names if rollout.excitable else rollout.torque_names
        self.action_space = Box(-1.0, 1.0, (len(names),), np.float32)
        self.observation_space = Box(-GREATEST, GREATEST, (self.observed().shape[1],), np.float32)

    def reset(self, seed: int | None, random: np.random.Generator) -> None:
        """Put all instances back to their start; the generator has been given the seed."""
        self.start(np.ones(self.rollout.instances, dtype=bool), random)

    def start(self, mask: Flags, random: np.random.Generator) -> None:
        """Put instances back to their start, with noise."""
        seed = int(random.integers(2**31))
        self.rollout.reset(velocity_noise=self.settings.velocity_noise, seed=seed, mask=mask)

    def observed(self) -> Array:
        """(instances, numbers) float32."""
        observation = self.rollout.observation()
        parts = [
            observation["coordinates"].numpy()[:, self._seen],
            observation["speeds"].numpy(),
            observation["foot_force"].numpy().reshape(self.rollout.instances, 6) / np.float32(self._weight),
        ]
        if self.rollout.excitable:
            parts.append(observation["activation"].numpy())
        observed = np.nan_to_num(np.concatenate(parts, axis=1))
        return np.asarray(np.clip(observed, -GREATEST, GREATEST), dtype=np.float32)

    def act(self, actions: Any) -> tuple[Array, Flags, Flags]:
        """Rewards, terminated and truncated, (instances,), of a step of the environment with actions."""
        s, rollout = self.settings, self.rollout
        action = np.clip(np.nan_to_num(np.asarray(actions, dtype=np.float32)), -1.0, 1.0)
        before, cost = self._place(), self._cost()
        if rollout.excitable:
            effort = 0.5 + 0.5 * action
            rollout.step(int(s.frame_skip), excitations=effort)
        else:
            effort = action
            rollout.step(int(s.frame_skip), torques=effort * np.float32(s.torque_limit))
        status = self.status()
        failed = ~np.isin(status, (Status.RUNNING, Status.COMPLETED))
        reward = s.speed_weight * (self._place() - before) + s.alive_weight * self.dt * ~failed
        reward = reward - s.effort_weight * self.dt * np.square(effort).sum(axis=1) / max(effort.shape[1], 1)
        reward = reward - s.objective_weight * (self._cost() - cost)
        return reward.astype(np.float32), failed, status == Status.COMPLETED

    def status(self) -> NDArray[np.int32]:
        """How every instance is, see `Status`."""
        return np.array(self.rollout.status())

    def picture(self) -> NDArray[np.uint8]:
        """The first instance as it stands, (480, 640, 3); raises Error without the extra `video`."""
        self._pictures = self._pictures or Pictures(self.rollout)
        return self._pictures.of(self.rollout)

    def _place(self) -> Any:
        """How far forward every instance is, m."""
        if self._forward is None:
            return np.zeros(self.rollout.instances)
        return self.rollout.state.coordinates.numpy()[:, self._forward].astype(np.float64)

    def _cost(self) -> Any:
        """The scene's objective so far, if it counts."""
        if not self.settings.objective_weight:
            return 0.0
        return weighted(self.rollout.numeric, self.rollout.terms())


def metadata_of(bipeds: Bipeds | TaskBatch) -> dict[str, Any]:
    """What Gymnasium wants to know of an environment."""
    return {"render_modes": list(MODES), "render_fps": max(round(1.0 / bipeds.dt), 1)}


class BipedVectorEnv(VectorEnv[Array, Array, Any]):
    """Bipeds of one scene on one device, all in one batch.

    By default its autoreset mode is `AutoresetMode.SAME_STEP`: an instance whose episode ends starts again within the
    same call of `step`, which gives the first observation of the new episode, and the last one of the old in
    `info["final_obs"]` (rows of `info["_final_obs"]`). With `autoreset_mode="next_step"`, which wrappers such as
    `NormalizeObservation` want, that call gives the last observation, and the next one, whose action does not count for
    the instance, gives the first of the new episode, without reward.

    Attributes:
        bipeds: the batch; `bipeds.rollout` has its arrays on the device.
    """

    def __init__(
        self,
        num_envs: int = 1,
        scene: str | Scene = "fwalk",
        device: str | None = None,
        threads: int | None = None,
        render_mode: str | None = None,
        autoreset_mode: str | AutoresetMode = AutoresetMode.SAME_STEP,
        task: Task | Literal[False] | None = None,
        **settings: Any,
    ) -> None:
        """Prepare the batch.

        Args:
            num_envs: how many.
            scene: a scene, or what `load` takes for one.
            device, threads: as of `Rollout`.
            render_mode: `rgb_array`, or None to draw nothing.
            autoreset_mode: `same_step` or `next_step`.
            task: by default the scene's `[learning]`, if it has one; False to ignore it.
            settings: see `Settings`.

        Raises:
            SceneError, RolloutError: as `load`, `Rollout` and `EpisodeBatch`.
            Error: an unknown or impossible setting, or one beside a task.
        """
        self._restart, self.render_mode = checked_restart(autoreset_mode), checked_mode(render_mode)
        self.bipeds = batch_of(num_envs, scene, device, threads, task, settings)
        self.num_envs, self._ended = num_envs, np.zeros(num_envs, dtype=bool)
        self.metadata = metadata_of(self.bipeds) | {"autoreset_mode": self._restart}
        self.single_action_space = self.bipeds.action_space
        self.single_observation_space = self.bipeds.observation_space
        self.action_space = batch_space(self.single_action_space, num_envs)
        self.observation_space = batch_space(self.single_observation_space, num_envs)

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Start all episodes.

        Args:
            seed: of all noise from now on; of several, which Gymnasium gives one an instance, the first.
            options: none are known.
        """
        first = seed[0] if isinstance(seed, list) else seed
        super().reset(seed=first, options=options)
        self.bipeds.reset(first, self.np_random)
        self._ended = np.zeros(self.num_envs, dtype=bool)
        return self.bipeds.observed(), {}

    def step(self, actions: Array) -> Step:
        """Act: observations, rewards, terminated, truncated, and what else Gymnasium wants to know of episodes' ends.

        Raises:
            Error: the actions are not (num_envs, actions).
        """
        reward, terminated, truncated = self.bipeds.act(actions)
        if self._restart is AutoresetMode.NEXT_STEP:
            return self._begun_again(reward, terminated, truncated)
        observed, ended = self.bipeds.observed(), terminated | truncated
        info: dict[str, Any] = {}
        if ended.any():
            info = {"final_obs": np.full(self.num_envs, None, dtype=object), "_final_obs": ended}
            info |= {"final_info": {"status": self.bipeds.status()}, "_final_info": ended}
            for index in np.flatnonzero(ended):
                info["final_obs"][index] = observed[index]
            self.bipeds.start(ended, self.np_random)
            observed = self.bipeds.observed()
        return observed, reward, terminated, truncated, info

    def _begun_again(self, reward: Array, terminated: Flags, truncated: Flags) -> Step:
        """What a step gives where episodes that ended in the one before begin, and those that end now wait."""
        begun = self._ended
        if begun.any():
            self.bipeds.start(begun, self.np_random)
        reward, terminated, truncated = np.where(begun, 0.0, reward), terminated & ~begun, truncated & ~begun
        self._ended = terminated | truncated
        info: dict[str, Any] = {}
        if self._ended.any():
            info = {"status": self.bipeds.status(), "_status": self._ended.copy()}
        return self.bipeds.observed(), reward.astype(np.float32), terminated, truncated, info

    def render(self) -> tuple[NDArray[np.uint8], ...] | None:
        """The first biped as it stands, if pictures were asked for."""
        return (self.bipeds.picture(),) if self.render_mode else None

    def call(self, name: str, *args: Any, **options: Any) -> tuple[Any, ...]:
        """What is asked of all, such as `render`, as Gymnasium's own vector environments are asked by some libraries.

        Returns:
            A tuple; of `render` without pictures an empty one.
        """
        value = getattr(self, name)
        value = value(*args, **options) if callable(value) else value
        return value if isinstance(value, tuple) else () if value is None else (value,) * self.num_envs


class BipedEnv(gymnasium.Env[Array, Array]):
    """One biped, which a policy drives; it starts again by `reset` only.

    Attributes:
        bipeds: the batch of one.
    """

    metadata: dict[str, Any] = {"render_modes": list(MODES)}  # noqa: RUF012, as Gymnasium has it

    def __init__(
        self,
        scene: str | Scene = "fwalk",
        device: str | None = None,
        threads: int | None = None,
        render_mode: str | None = None,
        task: Task | Literal[False] | None = None,
        **settings: Any,
    ) -> None:
        """Prepare the biped; see `BipedVectorEnv`."""
        self.render_mode = checked_mode(render_mode)
        self.bipeds = batch_of(1, scene, device, threads, task, settings)
        self.metadata = metadata_of(self.bipeds)
        self.action_space, self.observation_space = self.bipeds.action_space, self.bipeds.observation_space

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Start an episode; its first observation."""
        super().reset(seed=seed, options=options)
        self.bipeds.reset(seed, self.np_random)
        return self.bipeds.observed()[0], {}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Act: observation, reward, terminated, truncated, and the biped's status."""
        reward, terminated, truncated = self.bipeds.act(np.asarray(action)[None])
        status = Status(int(self.bipeds.status()[0]))
        observed = self.bipeds.observed()[0]
        return observed, float(reward[0]), bool(terminated[0]), bool(truncated[0]), {"status": status.name}

    def render(self) -> NDArray[np.uint8] | None:
        """The biped as it stands, (480, 640, 3), if pictures were asked for."""
        return self.bipeds.picture() if self.render_mode else None
