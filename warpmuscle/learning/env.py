"""The learning environment: episodes of many instances as tensors of PyTorch on their device."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import msgspec
import warp as wp

from warpmuscle.core.errors import Error, RolloutError
from warpmuscle.formats import SceneLike
from warpmuscle.kernels.learning.rewards import COMPLETED, COUNT, DECISIONS, ENDED, FORWARD
from warpmuscle.learning.episodes import EpisodeBatch
from warpmuscle.scene.learning import Task
from warpmuscle.simulation.extensions import words

try:
    import torch
except ModuleNotFoundError as error:
    raise Error('learning needs PyTorch: pip install "warpmuscle[learn]"') from error

Tensor = Any  # torch.Tensor


class RolloutEnv:
    """Many instances of one scene that a policy drives, on their device; nothing passes through the host.

    Tensors are the same in every call; a decision writes to them. On a GPU a decision is captured once, as a CUDA
    graph, and then launched as a whole; within a capture of others, `torch.cuda.graph`, its kernels are captured there.

    Example:
        env = RolloutEnv("walk56", 4096)
        observation = env.reset()
        for _ in range(1000):
            observation, reward, terminated, truncated = env.step(policy(observation))

    Attributes:
        num_envs, num_observations, num_actions: sizes. dt: s, between two decisions.
        max_episode_length: decisions, after which an episode is truncated.
        observation_names, critic_names, action_names, command_names: of the columns.
        observation: (num_envs, observations). final_observation: the last one of the episode that ended in this step,
            where one did. critic_observation: all that is observed, without delay and noise, and what only the
            simulation knows.
        reward, terminated, truncated: (num_envs,) of the last step.
        episode_length: (num_envs,) int32, decisions of the present episode; may be written to.
        commands: (num_envs, commands) m/s, rad/s, then wanted coordinates; may be written to.
        action_range: beyond which actions do what its ends do; None if they do more all the way.
        muscle_shares: (actions,) of the muscles that they excite in the mass of all; None if they do something else.
        images: of observations and actions in a mirror, see `symmetry`; None where the task is not symmetric.
        capture: whether decisions on a GPU are captured as a graph.
        batch: the episodes; `batch.rollout.state` is the state of the instances.
    """

    def __init__(
        self,
        scene: SceneLike,
        instances: int = 1,
        device: str | None = None,
        task: Task | None = None,
        seed: int = 0,
        *,
        record: Sequence[int] = (),
        threads: int | None = None,
        trust: bool = False,
        capture: bool = True,
    ) -> None:
        """Prepare and begin all episodes; the first time a kernel is compiled.

        Args:
            scene, instances, device, task, seed, record, threads, trust: as of `EpisodeBatch`.
            capture: see there.

        Raises:
            SceneError, RolloutError: as `EpisodeBatch`.
        """
        self.batch = batch = EpisodeBatch(
            scene, instances, device, task, seed, record=record, threads=threads, trust=trust
        )
        self.scene, self.task, self.device = batch.scene, batch.task, torch.device(wp.device_to_torch(batch.device))
        self.num_envs, self.dt, self.max_episode_length = batch.rollout.instances, batch.dt, batch.longest
        self.observation_names, self.critic_names = tuple(batch.senses.names), batch.senses.critic_names
        self.action_names, self.command_names = batch.actions.names, batch.command_names
        self.num_observations, self.num_actions = len(self.observation_names), len(self.action_names)
        self.action_range, self.images = batch.actions.range, batch.images
        shares = batch.actions.muscle_shares
        self.muscle_shares = None if shares is None else torch.as_tensor(shares, dtype=torch.float32).to(self.device)
        gains, episodes = batch.judge.gains, batch.episodes
        self.observation, self.critic_observation, self.final_observation = map(
            wp.to_torch, (batch.senses.observation, batch.senses.critic, batch.final_observation)
        )
        self.reward, self.terminated, self.truncated = map(
            wp.to_torch, (gains.reward, gains.terminated, gains.truncated)
        )
        self.episode_length, self.commands = wp.to_torch(episodes.length), wp.to_torch(episodes.command)
        self._finished, self._requested = wp.to_torch(gains.finished), wp.to_torch(batch.actions.requested)
        self._custom_finished = torch.zeros((instances, 0), device=self.device)
        self._hardness, self._push_hardness = map(wp.to_torch, (episodes.hardness, episodes.push_hardness))
        if gains.custom_finished.size:
            self._custom_finished = wp.to_torch(gains.custom_finished)
        self.capture, self._graph = capture, None
        self._streams: dict[int, Any] = {}  # of Warp, by PyTorch's
        wp.synchronize_device(batch.device)

    def reset(self, seed: int | None = None) -> Tensor:
        """Begin all episodes anew; what is observed.

        Args:
            seed: of all that is drawn from now on; None to draw on.
        """
        with self._stream():
            self.batch.reset(seed)
        return self.observation

    def tighten(self, decisions: int) -> None:
        """Let limits, costs and rewards be those after so many decisions of all together; see `Tightening`.

        Until this is called, and where the task does not tighten them, they are the scene's own.
        """
        with self._stream():
            self.batch.limits.after(decisions)
            self.batch.judge.after(decisions)

    def step(self, actions: Tensor) -> tuple[Tensor, Tensor, Tensor, Tensor]:
        """Make a decision in every instance; where an episode ends, the next one begins.

        Args:
            actions: (num_envs, num_actions); see `Task`. What is not finite counts as 0.

        Returns:
            What is observed, the reward, and whether the episode ended by failing, or because it was long enough.

        Raises:
            RolloutError: another shape.
        """
        if tuple(actions.shape) != (self.num_envs, self.num_actions):
            wanted = f"({self.num_envs}, {self.num_actions})"
            raise RolloutError(f"actions have shape {tuple(actions.shape)}; this environment takes {wanted}")
        self._requested.copy_(actions.detach())
        with self._stream():
            self._decide()
        return self.observation, self.reward, self.terminated, self.truncated

    @property
    def log(self) -> dict[str, Tensor]:
        """Means over the instances of the last episode that ended in each, as tensors without dimensions.

        `time` s that it lasted, `completed` part of them that did not fail, `speed` m/s along the wanted way, `return`,
        and what every term of the reward gave a second. All zero until an episode has ended. `hardness` is that of the
        present episodes, see `Variation.growth`, and `push_hardness` that of pushes, see `Variation.push_growth`.
        """
        finished = self._finished
        ended = finished[:, ENDED].sum().clamp(min=1.0)
        decisions = finished[:, DECISIONS].clamp(min=1.0)
        rates = (finished[:, : COUNT + 1] / decisions[:, None]).sum(0) / ended
        own = (self._custom_finished / decisions[:, None]).sum(0) / ended
        sums = (finished[:, :COUNT].sum() + self._custom_finished.sum()) / ended
        log = {
            "time": finished[:, DECISIONS].sum() / ended * self.dt,
            "completed": finished[:, COMPLETED].sum() / ended,
            "speed": rates[FORWARD],
            "return": sums,
            "hardness": self._hardness.mean(),
            "push_hardness": self._push_hardness.mean(),
        }
        every = [*rates[:COUNT], *own]
        return log | {f"reward/{name}": every[k] / self.dt for k, name in enumerate(self.batch.judge.names)}

    @property
    def settings(self) -> dict[str, Any]:
        """The task as a table of plain values, with the scene's name."""
        return {"scene": self.scene.name, "num_envs": self.num_envs, "task": msgspec.to_builtins(self.task)}

    def state_dict(self) -> dict[str, Tensor]:
        """All that later decisions depend on, as tensors of the CPU, for `load_state_dict`."""
        arrays = enumerate(self.batch.state_arrays())
        return {str(k): _plain(array).contiguous().view(torch.uint8).flatten().cpu().clone() for k, array in arrays}

    def load_state_dict(self, state: dict[str, Tensor]) -> None:
        """Go on from where an environment of the same scene, task and size stood.

        Raises:
            RolloutError: it is of another one.
        """
        arrays = [_plain(array) for array in self.batch.state_arrays()]
        shapes = [tuple(state[str(k)].shape) if str(k) in state else None for k in range(len(arrays))]
        if len(state) != len(arrays) or shapes != [(array.nbytes,) for array in arrays]:
            raise RolloutError("this state is of an environment of another scene, task or number of instances")
        for k, array in enumerate(arrays):
            array.copy_(state[str(k)].view(array.dtype).view(array.shape))
        self.batch.check_state()
        with self._stream():
            self.batch.observe_again()

    def _decide(self) -> None:
        """Launch a decision: captured if possible."""
        device = self.batch.device
        if not (self.capture and device.is_cuda) or torch.cuda.is_current_stream_capturing():
            self.batch.step()
        elif self._graph is None:
            self.batch.step()  # loads what is yet to be loaded
            wp.synchronize_device(device)
            own = wp.Stream(device)  # the stream that PyTorch usually has cannot be captured
            with wp.ScopedStream(own), wp.ScopedCapture(stream=own, force_module_load=False) as capture:
                self.batch.step()
            self._graph = capture.graph
        else:
            wp.capture_launch(self._graph)

    @contextmanager
    def _stream(self) -> Iterator[None]:
        """Let Warp launch on PyTorch's present stream."""
        if not self.batch.device.is_cuda:
            yield
            return
        stream = torch.cuda.current_stream(self.device)
        if stream.cuda_stream not in self._streams:
            self._streams[stream.cuda_stream] = wp.stream_from_torch(stream)
        with wp.ScopedStream(self._streams[stream.cuda_stream], sync_enter=False):
            yield


def _plain(array: wp.array) -> Tensor:
    """An array of the state as a tensor of words or bytes on the same memory, in the order of the array's indices."""
    if array.ndim > 1:
        return wp.to_torch(words(array))
    size = wp.types.type_size_in_bytes(array.dtype)
    return wp.to_torch(wp.array(ptr=array.ptr, shape=(array.size * size,), dtype=wp.uint8, device=array.device))
