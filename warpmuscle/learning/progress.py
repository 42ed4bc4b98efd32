"""How far a training has come, as its user sees it."""

from __future__ import annotations

from dataclasses import dataclass

from warpmuscle.core.plain_text import number_of


@dataclass(frozen=True)
class TrainingProgress:
    """How far a training has come."""

    iterations: int
    decisions: int  # of all instances together, also before a resumption
    fraction: float  # of all the work, or of the time for it, 0..1
    rate: float  # decisions a second of wall time, in the last few iterations
    upright: float  # s, that the last episode of every instance lasted, mean
    completed: float  # share of those episodes that lasted their whole time
    speed: float  # m/s, along the wanted way, mean of them
    gain: float  # their rewards, mean
    hardness: float = 1.0  # share of what disturbs them where that grows, mean
    pushed: float = 1.0  # share of the greatest push, where pushes grow by themselves, mean
    compiling: bool = False
    trying: bool = False  # how good the policy is, with its actions' means

    def in_words(self) -> str:
        """The same, short."""
        if self.compiling:
            return "preparing to learn"
        return f"learning: {number_of(self.iterations, 'iteration')}, return {self.gain:.4g}"
