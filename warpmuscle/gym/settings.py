"""Numbers of the environments of scenes without a task."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from warpmuscle.core.errors import Error
from warpmuscle.scene.validation.checks import near


@dataclass(frozen=True)
class Settings:
    """What an environment is like beside its scene."""

    frame_skip: int = 20  # simulated steps a step of the environment
    speed_weight: float = 1.0  # 1/m
    alive_weight: float = 1.0  # 1/s
    effort_weight: float = 0.5  # 1/s
    objective_weight: float = 0.0
    torque_limit: float = 100.0  # N m
    velocity_noise: float = 0.01  # m/s, standard deviation of each component of the root's velocity at the start

    @classmethod
    def of(cls, values: dict[str, Any]) -> Settings:
        """The settings with other values of some of them; raises Error for an unknown or impossible one."""
        for name, value in values.items():
            if name not in cls.__dataclass_fields__:
                raise Error(f"there is no setting {name!r}{near(name, cls.__dataclass_fields__)}")
            if not isinstance(value, int | float) or not np.isfinite(value):
                raise Error(f"{name} must be a finite number, not {value!r}")
        settings = cls(**values)
        if settings.frame_skip < 1 or settings.frame_skip != int(settings.frame_skip):
            raise Error(f"frame_skip must be a positive whole number, not {settings.frame_skip}")
        if settings.velocity_noise < 0.0 or settings.torque_limit <= 0.0:
            raise Error("velocity_noise must not be negative, and torque_limit must be positive")
        return settings
