"""Where a replay stands: time, speed, and whether it plays; no drawing here."""

from __future__ import annotations

from dataclasses import dataclass

SPEEDS = (0.1, 0.25, 0.5, 1.0, 2.0, 4.0)


@dataclass
class Player:
    """A clock between 0 and `end` that starts again when it comes there."""

    end: float  # s
    interval: float  # s, between frames
    time: float = 0.0  # s
    speed: float = 1.0
    playing: bool = True

    def advance(self, passed: float) -> None:
        """Go on by a wall time, s, if it plays."""
        if self.playing:
            self.time += passed * self.speed
            if self.time > self.end:
                self.time = self.time % self.end if self.end > 0.0 else 0.0

    def play(self, on: bool) -> None:
        """Play or pause; from the start where it had come to the end."""
        if on and self.time >= self.end:
            self.time = 0.0
        self.playing = on

    def seek(self, time: float) -> None:
        """Go to a time, s, or to the nearest one that there is."""
        self.time = min(max(time, 0.0), self.end)

    def step(self, frames: int) -> None:
        """Pause, and go some frames on or back."""
        self.playing = False
        self.seek((round(self.time / self.interval) + frames) * self.interval)
