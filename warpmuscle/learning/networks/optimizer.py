"""Adam on all parameters as one vector, whose learning rates are on the device."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor, nn

DECAYS = 0.9, 0.999
SMALL = 1e-8


class FlatAdam:
    """Adam (Kingma and Ba 2015, algorithm 1) of modules whose parameters become parts of one vector.

    A step is a handful of operations whatever the number of layers, none of which waits for the host, so that it can be
    captured in a CUDA graph; and all that it knows is three vectors.

    Attributes:
        values, first, second: (P,) parameters, and means of gradients and of their squares.
        rate: (), the learning rate of groups that have none of their own. steps: (), how many were made.
    """

    def __init__(
        self, groups: Sequence[Sequence[nn.Parameter]], rate: float, longest: float, own: Sequence[float] = ()
    ) -> None:
        """Take over parameters.

        Args:
            groups: of parameters whose gradients are shortened together. longest: that a group's gradient may be.
            own: learning rate of each group that never changes; 0, or none: it has `rate`.
        """
        every = [parameter for group in groups for parameter in group]
        self.values = torch.cat([parameter.detach().reshape(-1) for parameter in every])
        self._gradient = torch.zeros_like(self.values)
        self.first, self.second = torch.zeros_like(self.values), torch.zeros_like(self.values)
        self.rate = torch.full((), rate, device=self.values.device)
        self.steps = torch.zeros((), device=self.values.device)
        self._longest = longest
        self._groups: list[Tensor] = []
        self._parts: list[slice] = []
        self._own = [*own, *[0.0] * (len(groups) - len(own))]
        end = 0
        for group in groups:
            begin = end
            for parameter in group:
                part = slice(end, end + parameter.numel())
                parameter.data = self.values[part].view_as(parameter)
                parameter.grad = self._gradient[part].view_as(parameter)
                end = part.stop
            self._groups.append(self._gradient[begin:end])
            self._parts.append(slice(begin, end))

    def restart(self, rate: float) -> None:
        """Be as before the first step, but for the parameters."""
        for tensor in (self.first, self.second, self.steps):
            tensor.zero_()
        self.rate.fill_(rate)

    def forget(self) -> None:
        """Let gradients be zero, before those of the next step are added."""
        self._gradient.zero_()

    def step(self) -> None:
        """Change the parameters by their gradients; to be called where none are followed.

        The gradient of a group that is not finite counts as zero.
        """
        for group in self._groups:
            length = torch.linalg.vector_norm(group)
            shorter = group * (self._longest / (length + 1e-6)).clamp(max=1.0)
            group.copy_(torch.where(torch.isfinite(length), shorter, 0.0))
        self.steps.add_(1.0)
        g, (b1, b2) = self._gradient, DECAYS
        self.first.lerp_(g, 1.0 - b1)
        self.second.mul_(b2).addcmul_(g, g, value=1.0 - b2)
        root = (self.second / (1.0 - b2**self.steps)).sqrt_().add_(SMALL)
        change, seen = self.first / root, 1.0 - b1**self.steps
        for part, own in zip(self._parts, self._own, strict=True):
            self.values[part].sub_(change[part] * ((own or self.rate) / seen))
