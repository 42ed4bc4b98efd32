"""Proximal policy optimisation (Schulman and others 2017, arXiv:1707.06347) without a word to the host."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import torch
from torch import Tensor

from warpmuscle.learning.networks.actor_critic import ActorCritic
from warpmuscle.learning.networks.mirrors import Mirrors
from warpmuscle.learning.networks.optimizer import FlatAdam
from warpmuscle.learning.options import PPOOptions


@dataclass(frozen=True)
class Experience:
    """What n instances met with in T steps under one policy; (T, n, ...) each."""

    observation: Tensor
    privileged: Tensor
    action: Tensor
    mean: Tensor  # of the policy's actions
    likelihood: Tensor  # (T, n), logarithm, of the action
    value: Tensor  # (T, n), by the critic
    reward: Tensor  # (T, n), with the value of what a truncated episode would have brought
    done: Tensor  # (T, n), 1 where the step ended an episode, else 0

    @classmethod
    def empty(
        cls, steps: int, instances: int, observations: int, privileged: int, actions: int, device: torch.device
    ) -> Experience:
        """Zeros, to be written into."""

        def zeros(*size: int) -> Tensor:
            return torch.zeros((steps, instances, *size), device=device)

        return cls(
            zeros(observations), zeros(privileged), zeros(actions), zeros(actions), zeros(), zeros(), zeros(), zeros()
        )

    @property
    def samples(self) -> int:
        """How many steps of single instances there are."""
        return int(self.reward.numel())


def advantages(reward: Tensor, value: Tensor, done: Tensor, last: Tensor, discount: float, trace: float) -> Tensor:
    """(T, n) how much better actions were than expected; Schulman and others 2016 (arXiv:1506.02438), eq. 16.

    Args:
        reward, value, done: (T, n). last: (n,) value of the state after the last step.
        discount, trace: gamma and lambda there.
    """
    found = torch.empty_like(value)
    following, advantage = last, torch.zeros_like(last)
    for t in reversed(range(len(reward))):
        goes_on = 1.0 - done[t]
        surprise = reward[t] + discount * goes_on * following - value[t]
        advantage = surprise + discount * trace * goes_on * advantage
        found[t] = advantage
        following = value[t]
    return found


class Effort(NamedTuple):
    """What actions excite, and what it weighs."""

    shares: Tensor  # (actions,) of muscles in the mass of all
    none: float  # action that excites nothing
    full: float

    def of(self, mean: Tensor) -> Tensor:
        """() mean over (n, actions) of squared excitations, weighted by the masses of their muscles."""
        excitation = ((mean - self.none) / (self.full - self.none)).clamp(0.0, 1.0)
        return (excitation * excitation * self.shares).sum(-1).mean()


class PPO:
    """Makes a policy and its critic better by what they have met with.

    Attributes:
        order: (epochs, minibatches, size) numbers of the samples in each minibatch, to be drawn before `update`; those
            beyond the number of samples are of their mirror images, in the same order.
        min_log_deviation, max_log_deviation: () to be set before `update`; the latter of use where options bound it.
        statistics: (4,) means over minibatches: policy loss, value loss, divergence from the old policy, share clipped.
    """

    def __init__(
        self, networks: ActorCritic, experience: Experience, options: PPOOptions, mirrors: Mirrors | None = None,
        effort: Effort | None = None,
    ) -> None:  # fmt: skip
        """Prepare to learn from this experience, again and again; with mirrors, every other sample as its image."""
        self.networks, self.experience, self.options = networks, experience, options
        self._mirrors, self._effort = mirrors, effort
        policy = [*networks.policy.parameters(), networks.log_deviation]
        critic, rates = list(networks.value.parameters()), [0.0, options.critic_rate]
        self.adam = FlatAdam([policy, critic], options.learning_rate, options.max_gradient, rates)
        device = experience.reward.device
        size = experience.samples // options.minibatches
        self.order = torch.zeros((options.epochs, options.minibatches, size), dtype=torch.int64, device=device)
        self.min_log_deviation = torch.full((), options.min_log_deviation(0), device=device)
        self.max_log_deviation = torch.zeros((), device=device)
        self.statistics = torch.zeros(4, device=device)

    def shuffle(self, random: torch.Generator) -> None:
        """Draw the order of the samples in all epochs."""
        _, count, size = self.order.shape
        for epoch in self.order:
            drawn = torch.randperm(self.experience.samples, generator=random, device=epoch.device)
            if self._mirrors is not None:
                images = torch.randint(2, drawn.shape, generator=random, device=epoch.device)
                drawn = drawn + self.experience.samples * images
            epoch.copy_(drawn[: count * size].view(count, size))

    def bound_deviation(self) -> None:
        """Let noise be within its bounds; also before actions are drawn, since an update relies on what drew them."""
        with torch.no_grad():
            noise = self.networks.log_deviation
            noise.copy_(torch.maximum(noise, self.min_log_deviation))
            if self.options.end_deviation:
                noise.copy_(torch.minimum(noise, self.max_log_deviation))

    def begin_anew(self) -> None:
        """Forget what earlier gradients were like, and how the learning rate has adapted to them."""
        self.adam.restart(self.options.learning_rate)

    def update(self, last: Tensor, critic_alone: bool = False) -> None:
        """Learn from the experience.

        Args:
            last: (n,) value of the states after it. critic_alone: leave the policy as it is.
        """
        options, seen = self.options, self.experience
        with torch.no_grad():
            advantage = advantages(seen.reward, seen.value, seen.done, last, options.discount, options.trace)
            returns = advantage + seen.value
            deviation, mean = torch.var_mean(advantage)
            advantage = (advantage - mean) * torch.rsqrt(deviation + 1e-8)
            old = self.networks.log_deviation.detach().clone()
            self.statistics.zero_()
            columns = [seen.observation, seen.privileged, seen.action, seen.mean]
            wide = [column.flatten(0, 1) for column in columns]
            narrow = [column.flatten() for column in (seen.likelihood, seen.value, advantage, returns)]
            own = torch.ones_like(narrow[0])
            if self._mirrors is not None:
                wide = [torch.cat([column, image]) for column, image in zip(wide, self._mirrors.of(*wide), strict=True)]
                narrow = [column.repeat(2) for column in narrow]
                own = torch.cat([own, torch.zeros_like(own)])
            wide[:2] = self.networks.observed(wide[0]), self.networks.privileged(wide[1])
            if self._mirrors is not None and options.mirrored == "noise":
                images = slice(len(own) // 2, None)
                noise = wide[2][images] - wide[3][images]
                wide[3][images] = self.networks.policy(wide[0][images])
                wide[2][images] = wide[3][images] + noise
                narrow[0][images] = self.networks.log_likelihood(wide[3][images], wide[2][images])
                own.fill_(1.0)
        for epoch in self.order:
            for chosen in epoch:
                if critic_alone:
                    self._improve_critic(wide[1][chosen], narrow[3][chosen])
                else:
                    self._improve(old, *(column[chosen] for column in (*wide, *narrow, own)))

    def _improve(
        self, old: Tensor, observation: Tensor, privileged: Tensor, action: Tensor, old_mean: Tensor,
        old_likelihood: Tensor, old_value: Tensor, advantage: Tensor, returns: Tensor, own: Tensor,
    ) -> None:  # fmt: skip
        """One step on a minibatch of normal observations.

        Args:
            old: logarithm of the deviation that acted. own: 1 where `old_mean` is what the policy did, 0 of mirror
                images whose mean actions need not be images of means, so that they say nothing of the divergence.
        """
        options, networks = self.options, self.networks
        mean, value = networks.policy(observation), networks.value(privileged)[:, 0]
        ratio = torch.exp(networks.log_likelihood(mean, action) - old_likelihood)
        clipped = ratio.clamp(1.0 - options.clip, 1.0 + options.clip)
        policy_loss = -torch.minimum(ratio * advantage, clipped * advantage).mean()
        if options.mirror_weight and self._mirrors is not None:
            policy_loss = policy_loss + options.mirror_weight * self._asymmetry(observation, mean)
        if options.effort_weight and self._effort is not None:
            policy_loss = policy_loss + options.effort_weight * self._effort.of(mean)
        missed = (value - returns) ** 2
        if options.value_clip:
            near = old_value + (value - old_value).clamp(-options.value_clip, options.value_clip)
            missed = torch.maximum(missed, (near - returns) ** 2)
        value_loss = missed.mean()
        entropy = networks.log_deviation.sum()
        self.adam.forget()
        (policy_loss + options.value_weight * value_loss - options.entropy_weight * entropy).backward()
        with torch.no_grad():
            divergence = _divergence(old_mean, old, mean, networks.log_deviation, own)
            self._adapt(divergence)
            self.adam.step()
            self.bound_deviation()
            outside = ((ratio - 1.0).abs() > options.clip).float().mean()
            statistics = torch.stack([policy_loss.detach(), value_loss.detach(), divergence, outside])
            self.statistics.add_(torch.nan_to_num(statistics) / self.order[:, :, 0].numel())

    def _asymmetry(self, observation: Tensor, mean: Tensor) -> Tensor:
        """() nat, how far the policy is from its image in a mirror; Yu and others 2018 (arXiv:1801.08093), mirror loss.

        Args:
            observation: (n, O), normal. mean: (n, actions) of the policy there.
        """
        mirrors, networks = self._mirrors, self.networks
        assert mirrors is not None
        with torch.no_grad():
            image = networks.observed(mirrors.observation.of(networks.observed.usual(observation)))
            wanted = mirrors.action.of(networks.policy(image))
        distance = (mean - wanted) * torch.exp(-networks.log_deviation.detach())
        return 0.5 * (distance * distance).sum(-1).mean()

    def _improve_critic(self, privileged: Tensor, returns: Tensor) -> None:
        """One step of the critic alone on a minibatch of normal observations; it may change as far as it must."""
        self.adam.forget()
        value_loss = ((self.networks.value(privileged)[:, 0] - returns) ** 2).mean()
        (self.options.value_weight * value_loss).backward()
        with torch.no_grad():
            self.adam.step()
            self.statistics[1].add_(value_loss / self.order[:, :, 0].numel())

    def _adapt(self, divergence: Tensor) -> None:
        """Learn slower where the policy changes too fast, and faster where it hardly does."""
        options, rate = self.options, self.adam.rate
        if options.divergence:
            slower = (divergence > 2.0 * options.divergence).float()
            faster = (divergence < 0.5 * options.divergence).float()
            factor = 1.0 + slower * (1.0 / options.rate_factor - 1.0) + faster * (options.rate_factor - 1.0)
            rate.mul_(factor).clamp_(options.min_learning_rate, options.max_learning_rate)


def _divergence(old_mean: Tensor, old: Tensor, mean: Tensor, new: Tensor, weight: Tensor) -> Tensor:
    """() mean Kullback-Leibler divergence of Gaussian policies with these means and logarithms of deviations.

    Args:
        weight: (n,) of samples in the mean.
    """
    spread = torch.exp(2.0 * (old - new))
    distance = ((old_mean - mean) * torch.exp(-new)) ** 2
    each = (new - old + 0.5 * (spread + distance - 1.0)).sum(-1)
    return (each * weight).sum() / weight.sum().clamp(min=1.0)
