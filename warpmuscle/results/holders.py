"""What has motions without being a result itself, such as a run or a rollout, as figures and pages take it."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from warpmuscle.results.recording import Recording
from warpmuscle.results.records import Result


@runtime_checkable
class HasResult(Protocol):
    """What holds a result, as a run does."""

    @property
    def result(self) -> Result:
        """All that was recorded, with its scene."""


@runtime_checkable
class HasRecordings(Protocol):
    """What has recorded motions of several instances, as a rollout does."""

    @property
    def recorded_instances(self) -> tuple[int, ...]:
        """Their numbers."""

    def recording(self, instance: int | None = None, start: float = 0.0) -> Recording:
        """The motion of one of them."""
