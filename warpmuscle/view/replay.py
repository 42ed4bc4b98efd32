"""Recorded motions in a viser server, with a timeline."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from warpmuscle.scene import Scene
from warpmuscle.view.curves import panels_of
from warpmuscle.view.player import SPEEDS, Player
from warpmuscle.view.track import Track
from warpmuscle.view.viewer import Viewer

START, BACK, NEXT = "|< start", "< back", "next >"
REFRESH = 0.2  # s of wall time between two places of slider and cursor while it plays


class Replay(Viewer):
    """Plays tracks side by side."""

    def __init__(self, server: Any, tracks: Sequence[Track], scenes: Sequence[Scene]) -> None:
        """Show tracks and their scenes without free parameters, which are alike in their ground."""
        super().__init__(server, tracks, scenes[0].ground)
        self.tracks, self._scenes = list(tracks), list(scenes)
        longest = max(tracks, key=lambda track: float(track.recording.time[-1]))
        end = float(longest.recording.time[-1])
        self.player = Player(end, max(end / max(longest.frames - 1, 1), 1e-3))
        self._shown_time, self._last_due = -1.0, 0.0
        self._make_timeline()
        self.selected = 0
        self._make_choice()
        self._make_common(self._panels(0), tracks[0].recording.time, self._refresh)
        self._refresh()

    def _panels(self, number: int) -> Any:
        return panels_of(self.tracks[number].recording, self._scenes[number])

    def _make_timeline(self) -> None:
        gui, player = self.server.gui, self.player
        with gui.add_folder("Timeline"):
            self.play_button = gui.add_button("Pause")
            self.slider = gui.add_slider("time, s", 0.0, max(player.end, 1e-3), max(player.end, 1e-3) / 2000.0, 0.0)
            self.steps = gui.add_button_group("frame", (START, BACK, NEXT))
            self.speed = gui.add_dropdown("speed", [f"{speed:g}" for speed in SPEEDS], initial_value="1")

        self.play_button.on_click(lambda _: self.play(not player.playing))
        self.slider.on_update(self._on_slider)
        self.steps.on_click(self._on_step)
        self.speed.on_update(lambda _: setattr(player, "speed", float(self.speed.value)))

    def _on_slider(self, event: Any) -> None:
        if event.client is not None:  # moved by hand
            with self.lock:
                self.player.seek(self.slider.value)

    def _on_step(self, _: Any) -> None:
        with self.lock:
            if self.steps.value == START:
                self.player.seek(0.0)
            else:
                self.player.step(-1 if self.steps.value == BACK else 1)
                self._label()

    def _make_choice(self) -> None:
        if len(self.tracks) == 1:
            return
        names = [f"{number + 1}: {track.label}" for number, track in enumerate(self.tracks)]
        choice = self.server.gui.add_dropdown("plots of", names, initial_value=names[0])
        choice.on_update(lambda _: self.choose(names.index(choice.value)))

    def choose(self, number: int) -> None:
        """Plot the curves of another track."""
        with self.lock:
            self.selected = number
            self.plots.replace(self._panels(number), self.tracks[number].recording.time)
            self.plots.show(self.player.time)

    def play(self, on: bool) -> None:
        """Play or pause."""
        with self.lock:
            self.player.play(on)
            self._label()

    def _label(self) -> None:
        self.play_button.label = "Pause" if self.player.playing else "Play"

    def frames(self) -> list[int]:
        """The frame of each track that is shown."""
        times = (track.recording.time for track in self.tracks)
        last = self.player.time + 1e-9
        return [max(int(np.searchsorted(time, last, side="right")) - 1, 0) for time in times]

    def _advance(self, passed: float) -> None:
        self.player.advance(passed)
        if self.player.time != self._shown_time:
            self._refresh()

    def _refresh(self) -> None:
        moved = self.player.time != self._shown_time
        self._shown_time = self.player.time
        self.stage.show(self.tracks, self.frames())
        self.pictures += 1
        if moved and (not self.player.playing or self._is_due()):
            self.slider.value = self.player.time
            self.plots.show(self.player.time)

    def _is_due(self) -> bool:
        """Whether slider and plots, which cost the browser more than the scene, are to move again."""
        now = time.monotonic()
        if now - self._last_due < REFRESH:
            return False
        self._last_due = now
        return True
