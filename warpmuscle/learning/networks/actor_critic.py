"""The networks that learn: a policy that says how to act, and a critic that says how well it will go from here."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import torch
from torch import Tensor, nn

SMALL_VARIANCE = 1e-6
WIDEST = 8.0  # standard deviations, at which what networks see is cut off
UNHEARD = 1e6  # deviation of what was always the same, such as the only speed: nobody learnt what else it would mean
CONSTANT = 0.01  # of the small variance, below which an observation was the same all the time
LAST_GAIN = 0.01  # of the policy's last layer, so that all actions begin near zero


class Normalizer(nn.Module):  # type: ignore[misc]  # PyTorch need not be there
    """Brings observations to mean 0 and variance 1, by those of all that were seen."""

    mean: Tensor
    variance: Tensor
    count: Tensor

    def __init__(self, size: int) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(size))
        self.register_buffer("variance", torch.ones(size))
        self.register_buffer("count", torch.zeros(()))

    def forward(self, values: Tensor) -> Tensor:
        """(..., size) of mean 0 and variance 1, cut off at `WIDEST`."""
        normal: Tensor = (values - self.mean) * torch.rsqrt(self.variance + SMALL_VARIANCE)
        return normal.clamp(-WIDEST, WIDEST)

    def usual(self, normal: Tensor) -> Tensor:
        """(..., size) values in their own units, of those that `forward` has made normal."""
        values: Tensor = normal / torch.rsqrt(self.variance + SMALL_VARIANCE) + self.mean
        return values

    def see(self, values: Tensor) -> None:
        """Count in (n, size) further values; Chan, Golub and LeVeque 1983, eq. 1.5."""
        n = float(len(values))
        variance, mean = torch.var_mean(values, dim=0, correction=0)
        total = self.count + n
        difference = mean - self.mean
        self.variance.mul_(self.count / total).add_(variance * (n / total))
        self.variance.add_(difference * difference * (self.count * n / (total * total)))
        self.mean.add_(difference * (n / total))
        self.count.copy_(total)


class ActorCritic(nn.Module):  # type: ignore[misc]
    """A Gaussian policy whose deviation does not depend on what is observed, and a critic of the same hidden layers.

    Attributes:
        observed, privileged: normalise what the policy and what the critic sees.
        log_deviation: (actions,) of the policy.
    """

    def __init__(
        self, observations: int, privileged: int, actions: int, hidden: Sequence[int], deviation: float, seed: int
    ) -> None:
        """Make networks of random weights.

        Args:
            observations, privileged, actions: how many numbers the policy sees, the critic sees, and the policy gives.
            hidden: sizes of the hidden layers. deviation: of actions at first. seed: of the weights.
        """
        super().__init__()
        random = torch.Generator().manual_seed(seed)
        self.observed, self.privileged = Normalizer(observations), Normalizer(privileged)
        self.policy = _layers([observations, *hidden, actions], random)
        self.value = _layers([privileged, *hidden, 1], random)
        self.log_deviation = nn.Parameter(torch.full((actions,), math.log(deviation)))
        with torch.no_grad():
            last = self.policy[-1]
            assert isinstance(last, nn.Linear)
            last.weight.mul_(LAST_GAIN)
            last.bias.zero_()

    def act(self, observation: Tensor) -> Tensor:
        """(n, actions) means of the policy's actions."""
        mean: Tensor = self.policy(self.observed(observation))
        return mean

    def judge(self, privileged: Tensor) -> Tensor:
        """(n,) rewards to come, discounted."""
        value: Tensor = self.value(self.privileged(privileged))
        return value[..., 0]

    def log_likelihood(self, mean: Tensor, action: Tensor) -> Tensor:
        """(n,) logarithm of the density of actions, without its constant."""
        distance = (action - mean) * torch.exp(-self.log_deviation)
        return -(0.5 * distance * distance + self.log_deviation).sum(-1)


def _layers(sizes: Sequence[int], random: torch.Generator) -> nn.Sequential:
    """Linear layers with ELU between them."""
    layers: list[nn.Module] = []
    for number, (inputs, outputs) in enumerate(itertools.pairwise(sizes)):
        layer = nn.Linear(inputs, outputs)
        bound = 1.0 / math.sqrt(inputs)
        with torch.no_grad():
            layer.weight.uniform_(-bound, bound, generator=random)
            layer.bias.uniform_(-bound, bound, generator=random)
        layers += [nn.ELU()] * (number > 0) + [layer]
    return nn.Sequential(*layers)
