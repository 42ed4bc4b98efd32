"""Images of a body's observations and actions in a mirror, as PyTorch makes them."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from warpmuscle.learning.symmetry import Image, Images


class Mirror(NamedTuple):
    """Makes images of rows of numbers, see `symmetry.Image`."""

    place: Tensor
    sign: Tensor
    shift: Tensor

    def of(self, values: Tensor) -> Tensor:
        """(n, N) images of (n, N)."""
        image: Tensor = values[:, self.place] * self.sign + self.shift
        return image


class Mirrors(NamedTuple):
    """Of what a policy and a critic see, and of actions."""

    observation: Mirror
    privileged: Mirror
    action: Mirror

    def of(self, observation: Tensor, privileged: Tensor, action: Tensor, mean: Tensor) -> list[Tensor]:
        """Images of what was seen, of actions, and of their means, (n, ...) each."""
        return [
            self.observation.of(observation),
            self.privileged.of(privileged),
            self.action.of(action),
            self.action.of(mean),
        ]


def mirrors_of(images: Images, device: torch.device) -> Mirrors:
    """Those of an environment, on its device."""

    def mirror(image: Image) -> Mirror:
        place, sign, shift = (torch.as_tensor(part, device=device) for part in image)
        return Mirror(place, sign.float(), shift.float())

    return Mirrors(*map(mirror, images))
