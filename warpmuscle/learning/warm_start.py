"""A training that begins with another policy's networks instead of noise."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import ResultError, RolloutError
from warpmuscle.core.plain_text import few_of
from warpmuscle.learning.collector import Environment
from warpmuscle.learning.networks.actor_critic import SMALL_VARIANCE, UNHEARD, ActorCritic, Normalizer
from warpmuscle.learning.options import PPOOptions, bounded, options_of
from warpmuscle.learning.player import task_of
from warpmuscle.results.learned import Ancestor, Learned, PolicyTable
from warpmuscle.results.result import read
from warpmuscle.scene.learning import Task

CRITIC_ITERATIONS = 20  # in which the critic learns what the policy is worth now, by default
SAME = ("actions", "action_offset", "action_scale")  # of a task, without which actions mean something else


def source_in(path: str | Path) -> Learned:
    """The policy of a result file to begin with, which itself becomes the first of its ancestors.

    Raises:
        ResultError: it cannot be read, or holds no policy.
    """
    result = read(path)
    learned = result.learned
    if learned is None:
        raise ResultError(f"{path}: holds no policy; `warpmuscle learn` makes one")
    itself = Ancestor(Path(path).name, result.seed, learned.decisions, result.command)
    return replace(learned, ancestors=(itself, *learned.ancestors))


def options_from(source: Learned, values: Mapping[str, Any]) -> PPOOptions:
    """Options of a training that begins with a policy: what is not said is as the policy is, or was learnt.

    Raises:
        Error: an option is unknown or impossible. RolloutError: the policy has other hidden layers.
    """
    hidden = tuple(len(layer.bias) for layer in source.policy.layers[:-1])
    rates = source.curve["learning_rate"]
    known: dict[str, Any] = {"hidden": hidden, "critic_iterations": CRITIC_ITERATIONS}
    known["deviation"] = float(noise_of(source).max())
    if len(rates) and rates[-1] > 0.0:
        known["learning_rate"] = float(rates[-1])
    options = options_of(bounded(known, values))
    if options.hidden != hidden:
        raise RolloutError(
            f"the policy to begin with has hidden layers of {_sizes(hidden)}, not {_sizes(options.hidden)}"
        )
    return options


def noise_of(source: Learned) -> Floats:
    """(actions,) standard deviation of the noise that a policy acted with when its training ended."""
    policy, mean = source.policy, source.curve["deviation"]
    if policy.noise is not None:
        return np.asarray(policy.noise.deviation, dtype=np.float64)
    return np.full(len(policy.action), float(mean[-1]) if len(mean) else PPOOptions().deviation)


def check_fit(source: Learned, env: Environment, task: Task) -> None:
    """Raise RolloutError, in one line, unless all that a policy observes is there, and it moves what there is."""
    learnt_with = source.policy.observation
    here = tuple(name for name in env.observation_names if name in learnt_with)
    if set(here) != set(learnt_with):
        _check_names("observations", learnt_with, here)
    _check_names("actions", source.policy.action, env.action_names)
    learnt = task_of(source)
    for name in SAME:
        before, now = getattr(learnt, name), getattr(task, name)
        if before != now:
            raise RolloutError(f"the policy to begin with has learnt with learning.{name} {before}, not {now}")


def begin_with(
    source: Learned, networks: ActorCritic, names: tuple[str, ...], critic_names: tuple[str, ...], options: PPOOptions
) -> bool:
    """Take over a policy that fits, with its noise, and its critic if all that this one observes is there.

    Args:
        names, critic_names: what policy and critic are to observe, in order. What is new there says nothing at first.

    Returns:
        Whether the critic was taken over.
    """
    seen = float(sum(ancestor.decisions for ancestor in source.ancestors))
    _take(networks.policy, networks.observed, hearing(source.policy, names), seen)
    critic = source.critic
    bare = tuple(name.partition(".")[2] for name in critic_names)  # as older files have them
    if critic is not None and critic.observation == bare:
        critic = replace(critic, observation=critic_names)
    known = critic is not None and not Counter(critic.observation) - Counter(critic_names)
    judges = known and critic is not None and _shapes(critic)[1:] == _shapes_of(networks.value)[1:]
    if judges and critic is not None:
        _take(networks.value, networks.privileged, hearing(critic, critic_names), seen)
    noise = noise_of(source)
    with torch.no_grad():
        networks.log_deviation.copy_(torch.as_tensor(np.log(noise * (options.deviation / noise.max()))))
    return judges


def hear(normalizer: Normalizer, values: Tensor) -> None:
    """Take what is usual from (n, size) values where a policy has always seen the same until now."""
    with torch.no_grad():
        unheard = (normalizer.variance == 0.0) & (normalizer.count > 0.0)
        variance, mean = torch.var_mean(values, dim=0, correction=0)
        normalizer.variance.copy_(torch.where(unheard, variance, normalizer.variance))
        normalizer.mean.copy_(torch.where(unheard, mean, normalizer.mean))


def hearing(table: PolicyTable, names: tuple[str, ...]) -> PolicyTable:
    """The same network for observations of these names, in their order: those that it does not know are unheard."""
    if table.observation == names:
        return table
    place = {name: k for k, name in enumerate(_numbered(table.observation))}
    new = [k for k, name in enumerate(_numbered(names)) if name not in place]
    column = np.array([place.get(name, 0) for name in _numbered(names)])
    mean, deviation, weight = table.mean[column], table.deviation[column], table.layers[0].weight[:, column]
    mean[new], deviation[new], weight[:, new] = 0.0, UNHEARD, 0.0
    first = replace(table.layers[0], weight=weight)
    return replace(table, observation=names, mean=mean, deviation=deviation, layers=(first, *table.layers[1:]))


def _numbered(names: Sequence[str]) -> list[tuple[str, int]]:
    """Names with how often each has come before: a slope may be drawn and be a command of the scene besides."""
    seen: Counter[str] = Counter()
    found = []
    for name in names:
        found.append((name, seen[name]))
        seen[name] += 1
    return found


def _take(layers: nn.Sequential, normalizer: Normalizer, table: PolicyTable, seen: float) -> None:
    """Put a network into layers of the same sizes; what it never heard of says nothing at first."""
    deviation = table.deviation.astype(np.float64)
    unheard = deviation >= UNHEARD
    linear = [layer for layer in layers if isinstance(layer, nn.Linear)]
    with torch.no_grad():
        for layer, kept in zip(linear, table.layers, strict=True):
            layer.weight.copy_(torch.as_tensor(kept.weight))
            layer.bias.copy_(torch.as_tensor(kept.bias))
        linear[0].weight[:, torch.as_tensor(unheard)] = 0.0
        variance = np.where(unheard, 0.0, np.maximum(deviation**2 - SMALL_VARIANCE, 0.0))
        normalizer.mean.copy_(torch.as_tensor(table.mean))
        normalizer.variance.copy_(torch.as_tensor(variance))
        normalizer.count.fill_(max(seen, 1.0))


def _shapes(table: PolicyTable) -> list[tuple[int, ...]]:
    return [layer.weight.shape for layer in table.layers]


def _shapes_of(layers: nn.Sequential) -> list[tuple[int, ...]]:
    return [tuple(layer.weight.shape) for layer in layers if isinstance(layer, nn.Linear)]


def _sizes(hidden: tuple[int, ...]) -> str:
    return "-".join(map(str, hidden)) or "none"


def _check_names(what: str, learnt: tuple[str, ...], found: tuple[str, ...]) -> None:
    """Raise RolloutError with the names that are lacking or new, or in another order."""
    if learnt == found:
        return
    lacking = [name for name in learnt if name not in found]
    new = [name for name in found if name not in learnt]
    parts = [f"{_some(names)} {how}" for names, how in ((lacking, "lacking here"), (new, "new")) if names]
    said = " and ".join(parts) or "the order is another"
    raise RolloutError(f"the policy to begin with has other {what}: {said}")


def _some(names: list[str]) -> str:
    """Names, or the first of them and how many there are, with the verb."""
    return few_of(list(map(repr, names)), 3) + (" is" if len(names) == 1 else " are")
