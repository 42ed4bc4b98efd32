"""Collects experience and learns from it, over and over; on a GPU as one CUDA graph."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import torch

from warpmuscle.core.errors import RolloutError
from warpmuscle.learning.collector import COUNTED, LOGGED, Collector, Environment
from warpmuscle.learning.networks.actor_critic import CONSTANT, SMALL_VARIANCE, UNHEARD, WIDEST, ActorCritic, Normalizer
from warpmuscle.learning.networks.mirrors import mirrors_of
from warpmuscle.learning.networks.ppo import PPO, Effort
from warpmuscle.learning.options import PPOOptions
from warpmuscle.learning.warm_start import begin_with, hear
from warpmuscle.results.learned import ClippedNoise, Layer, Learned, PolicyTable, Singles

LEARNT = ("policy_loss", "value_loss", "divergence", "clipped", "learning_rate", "deviation")


class Learner:
    """A policy that learns in an environment.

    Attributes:
        networks: policy and critic. kept: those that are kept as what was learnt, the same or the mean of theirs till
            now, see `PPOOptions.mean_decisions`. iterations: done so far.
    """

    def __init__(
        self, env: Environment, options: PPOOptions, seed: int, capture: bool = True, source: Learned | None = None
    ) -> None:
        """Prepare networks and a first look at what there is to observe.

        Args:
            capture: use a CUDA graph on a GPU. source: a policy to begin with, which fits; by default noise.
        """
        self.env, self.options = env, options
        env.tighten(0)
        device = env.reset().device
        if device.type == "cpu":
            torch.set_num_threads(
                1
            )  # which is faster for small layers, and gives the same bits with any number of cores
        privileged = env.critic_observation.shape[1]
        self.networks = ActorCritic(
            env.num_observations, privileged, env.num_actions, options.hidden, options.deviation, seed
        ).to(device)
        judges = source is None or begin_with(source, self.networks, env.observation_names, env.critic_names, options)
        self.collector = Collector(env, self.networks, options)
        self.mirrors = None if env.images is None else mirrors_of(env.images, device)
        shares, ends = env.muscle_shares, env.action_range
        effort = None if shares is None or ends is None else Effort(shares, *ends)
        if options.effort_weight and effort is None:
            raise RolloutError("effort_weight is for policies whose actions are the excitations of muscles")
        self.ppo = PPO(self.networks, self.collector.experience, options, self.mirrors, effort)
        if not judges:  # a critic that begins from noise learns as fast as any that does, until the policy goes on
            self.ppo.adam.restart(max(options.learning_rate, PPOOptions().learning_rate))
        self.random = torch.Generator(device).manual_seed(seed)
        self.iterations = 0
        self._captures = capture and device.type == "cuda"
        self._run: Callable[[], None] = self._work
        self._look_around(source is not None)
        self.kept = copy.deepcopy(self.networks) if options.mean_decisions else self.networks

    def _look_around(self, begun: bool) -> None:
        """Find out what observations are like, or those that a policy begun with never heard of."""
        self.collector.noise.normal_(generator=self.random)
        with tensor_cores():
            self.collector.collect()
            if begun:
                for normalizer, seen, images in self._seen():
                    hear(normalizer, seen if images is None else torch.cat([seen, images]))
            self._see()

    def iterate(self) -> dict[str, float]:
        """Collect experience and learn from it."""
        self.env.tighten(self.iterations * self.collector.experience.samples)
        self.collector.noise.normal_(generator=self.random)
        self.ppo.shuffle(self.random)
        self.ppo.min_log_deviation.fill_(self.options.min_log_deviation(self.iterations + 1))
        self.ppo.max_log_deviation.fill_(self.options.max_log_deviation(self.iterations + 1))
        self.ppo.bound_deviation()
        alone = self.options.critic_iterations
        if self.iterations < alone:
            self._work(critic_alone=True)
        else:
            if self.iterations == alone > 0:
                self.ppo.begin_anew()
            if self._captures and self.iterations == alone + 1:
                self._run = captured(self._work)
            self._run()
        self.iterations += 1
        self._keep()
        return self._statistics()

    def _work(self, critic_alone: bool = False) -> None:
        with tensor_cores():
            self.collector.collect()
            self.ppo.update(self.collector.last, critic_alone)
            self._see()

    def _keep(self) -> None:
        """Let the weights of now count in their mean."""
        share = self.options.mean_share(self.iterations)
        if self.kept is not self.networks:
            for mean, now in zip(tensors_of(self.kept), tensors_of(self.networks), strict=True):
                mean.lerp_(now, share)

    def _see(self) -> None:
        """Let what was observed count in what is usual."""
        with torch.no_grad():
            for normalizer, seen, images in self._seen():
                normalizer.see(seen)
                if images is not None:
                    normalizer.see(images)

    def _seen(self) -> Iterator[tuple[Normalizer, torch.Tensor, torch.Tensor | None]]:
        """What policy and critic have just observed, and its mirror images if there are any."""
        seen, networks, mirrors = self.collector.experience, self.networks, self.mirrors
        observation, privileged = seen.observation.flatten(0, 1), seen.privileged.flatten(0, 1)
        yield networks.observed, observation, None if mirrors is None else mirrors.observation.of(observation)
        yield networks.privileged, privileged, None if mirrors is None else mirrors.privileged.of(privileged)

    def _statistics(self) -> dict[str, float]:
        """How the iteration went, by the names of `results.learned.CURVE`; the host waits for it."""
        adam, collector = self.ppo.adam, self.collector
        deviation = torch.exp(self.networks.log_deviation.detach()).mean()
        numbers = [collector.counted, collector.logged, self.ppo.statistics, torch.stack([adam.rate, deviation])]
        row = iter(torch.cat(numbers).tolist())
        counted = dict(zip(COUNTED, row, strict=False))
        logged = dict(zip(LOGGED, row, strict=False))
        learnt = dict(zip(LEARNT, row, strict=True))
        decisions = collector.experience.samples
        return {
            "iteration": float(self.iterations),
            "decisions": float(self.iterations * decisions),
            "episodes": counted["episodes"],
            "completed": logged["completed"],
            "upright": logged["time"],
            "gain": logged["return"],
            "speed": logged["speed"],
            "hardness": logged["hardness"],
            "push_hardness": logged["push_hardness"],
            "reward": counted["reward"] / decisions,
            **learnt,
        }

    def state(self) -> dict[str, np.ndarray]:
        """All that a training goes on from, as arrays by name."""
        tensors = {f"environment.{name}": value for name, value in self.env.state_dict().items()}
        tensors |= self._tensors() | {"random": self.random.get_state()}
        arrays = {name: np.array(torch.as_tensor(value).cpu().numpy()) for name, value in tensors.items()}
        return arrays | {"iterations": np.array(self.iterations)}

    def restore(self, arrays: dict[str, np.ndarray]) -> None:
        """Go on from the state of an equal training.

        Raises:
            ValueError: an array is missing, or not as it should be.
        """
        inner = {name.partition(".")[2]: arrays[name] for name in arrays if name.startswith("environment.")}
        self.env.load_state_dict({name: torch.as_tensor(array) for name, array in inner.items()})
        for name, tensor in self._tensors().items():
            if name not in arrays or arrays[name].shape != tuple(tensor.shape):
                raise ValueError(f"state/{name} is missing, or has another shape than this training's")
            if not np.isfinite(arrays[name]).all():
                raise ValueError(f"state/{name} holds a value that is not finite")
            tensor.copy_(torch.as_tensor(arrays[name]))
        try:
            self.random.set_state(torch.as_tensor(arrays["random"]))
            self.iterations = int(arrays["iterations"])
        except (KeyError, TypeError, RuntimeError) as error:
            raise ValueError(f"state/random or state/iterations: {error}") from None

    def _tensors(self) -> dict[str, Any]:
        """What changes by learning, by name."""
        adam, collector, networks = self.ppo.adam, self.collector, self.networks
        found: dict[str, Any] = {name: getattr(adam, name) for name in ("values", "first", "second", "rate", "steps")}
        found["observation"] = collector.observation
        for name in ("observed", "privileged"):
            normalizer = getattr(networks, name)
            found |= {f"{name}_{part}": getattr(normalizer, part) for part in ("mean", "variance", "count")}
        if self.kept is not self.networks:
            found |= {f"kept_{number}": tensor for number, tensor in enumerate(tensors_of(self.kept))}
        return found

    def policy(self) -> PolicyTable:
        """The policy as it is now, for a result file."""
        networks, env = self.kept, self.env
        return _table(networks.policy, networks.observed, env.observation_names, env.action_names, self._noise())

    def critic(self) -> PolicyTable:
        """The critic as it is now, for a result file."""
        return _table(self.kept.value, self.kept.privileged, self.env.critic_names, ("value",), None)

    def _noise(self) -> ClippedNoise | None:
        """The noise that the policy has learnt with, if its actions are to be the mean over it."""
        ends = self.env.action_range
        if ends is None or not self.options.expected_action:
            return None
        return ClippedNoise(_array(torch.exp(self.kept.log_deviation)), *ends)


def tensors_of(networks: ActorCritic) -> list[torch.Tensor]:
    """All numbers of networks: their weights, and what is usual to observe."""
    return [tensor.detach() for tensor in (*networks.parameters(), *networks.buffers())]


def _table(
    network: torch.nn.Sequential, normalizer: Normalizer, inputs: tuple[str, ...], outputs: tuple[str, ...],
    noise: ClippedNoise | None,
) -> PolicyTable:  # fmt: skip
    """A network as a result file keeps it."""
    layers = [layer for layer in network if isinstance(layer, torch.nn.Linear)]
    deviation = torch.sqrt(normalizer.variance + SMALL_VARIANCE)
    deviation[normalizer.variance < CONSTANT * SMALL_VARIANCE] = UNHEARD
    parts = tuple(Layer(_array(layer.weight), _array(layer.bias)) for layer in layers)
    return PolicyTable(inputs, outputs, _array(normalizer.mean), _array(deviation), WIDEST, parts, noise)


def _array(tensor: torch.Tensor) -> Singles:
    """A copy on the host."""
    return np.array(tensor.detach().cpu().numpy(), dtype=np.float32)


@contextmanager
def tensor_cores() -> Iterator[None]:
    """Let products of matrices on a GPU round their factors to 10 bits (TF32), which noise of learning far exceeds."""
    rules = torch.backends.cuda.matmul
    before = rules.allow_tf32
    rules.allow_tf32 = True
    try:
        yield
    finally:
        rules.allow_tf32 = before


def captured(work: Callable[[], None]) -> Callable[[], None]:
    """Work that was done before, as a CUDA graph that does it again."""
    graph = torch.cuda.CUDAGraph()
    stream = torch.cuda.Stream()
    stream.wait_stream(torch.cuda.current_stream())
    with torch.cuda.graph(graph, stream=stream):
        work()
    torch.cuda.current_stream().wait_stream(stream)
    replay: Callable[[], None] = graph.replay
    return replay
