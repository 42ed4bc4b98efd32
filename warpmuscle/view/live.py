"""A simulation in a viser server that runs in real time, can be pushed, and whose parameters have sliders."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.status import Status
from warpmuscle.scene.parameters import Parameter
from warpmuscle.view.curves import panels_of
from warpmuscle.view.live_run import FARTHEST, FASTEST, SPEED_RATE, TURN_RATE, LiveRun, can_change_speed
from warpmuscle.view.packing import whole
from warpmuscle.view.player import SPEEDS
from warpmuscle.view.viewer import Viewer

SEEN = 5.0  # s of the motion in plots and path
REFRESH = 0.4  # s of wall time between two changes of them
PAUSE_AFTER_FALL = 1.0  # s of wall time before it starts again
ARROW = 0.5  # s of wall time that a push is seen
HARDEST = 100.0  # N s of a push
FEW = 24  # parameters whose sliders are all shown at once
DIRECTIONS = {"forwards": 0.0, "to the left": 90.0, "backwards": 180.0, "to the right": -90.0}  # degrees
AGAIN, STEP = "start again", "one frame on"
STEPS = 200  # of a slider


class Live(Viewer):
    """Runs a scene; what the panel says counts at once."""

    def __init__(self, server: Any, run: LiveRun) -> None:
        first = run.track()
        super().__init__(server, [first], run.numeric.ground)
        self.run, self.track = run, first
        self.playing, self.speed = True, 1.0
        self._changed, self._refreshed, self._ended = False, 0.0, 0.0
        self.parameters: dict[str, Any] = {}
        self.commands: dict[str, Any] = {}
        self._make_run()
        self._make_push()
        self._make_parameters()
        window = run.window(SEEN)
        self._make_common(panels_of(window, run.numeric), window.time, self._show)

    def _make_run(self) -> None:
        gui = self.server.gui
        with gui.add_folder("Simulation"):
            self.text = gui.add_markdown("")
            self.play_button = gui.add_button("Pause")
            self.others = gui.add_button_group("or", (AGAIN, STEP))
            self.speed_menu = gui.add_dropdown("speed", [f"{speed:g}" for speed in SPEEDS], initial_value="1")
            self.again = gui.add_checkbox("again after a fall", True)
        self.play_button.on_click(self._locked(lambda: self.play(not self.playing)))
        self.others.on_click(self._locked(self._other))
        self.speed_menu.on_update(lambda _: setattr(self, "speed", float(self.speed_menu.value)))

    def _other(self) -> None:
        if self.others.value == AGAIN:
            self.run.restart()
        else:
            self.play(False)
            self.run.step()
        self._show()

    def _make_push(self) -> None:
        gui = self.server.gui
        with gui.add_folder("Push"):
            self.push_button = gui.add_button("Push", color="orange")
            self.impulse = gui.add_slider("impulse, N s", 0.0, HARDEST, 1.0, 20.0)
            self.direction = gui.add_dropdown("direction", list(DIRECTIONS), initial_value="to the left")
        self.push_button.on_click(self._locked(self._push))
        self.pushes: list[Floats] = []  # impulses given, N s
        self._arrow: Any = None
        self._arrow_until = 0.0

    def _push(self) -> None:
        strength = min(max(self.impulse.value, 0.0), HARDEST)
        impulse = self.run.push(strength, np.radians(DIRECTIONS[self.direction.value]))
        self.pushes.append(impulse)
        if np.any(impulse):
            self._remove_arrow()
            self._arrow = self.stage.show_push(self.track.recording.root_position[0], impulse)
            self._arrow_until = time.monotonic() + ARROW

    def _remove_arrow(self) -> None:
        if self._arrow is not None:
            self._arrow.remove()
        self._arrow = None

    def _make_parameters(self) -> None:
        """Sliders for steering and for free parameters, those of one group at a time if there are many."""
        gui, run = self.server.gui, self.run
        if run.scene.commands:
            with gui.add_folder("Commands"):
                for name in run.scene.commands:
                    self._add_command(name)
        if run.scene.controller is not None:
            with gui.add_folder("Steer"):
                if can_change_speed(run.numeric.controller) and "speed" not in run.scene.commands:
                    rate = f"by {SPEED_RATE:g} m/s in each second"
                    self.faster = gui.add_slider("faster, m/s", -FASTEST, FASTEST, 0.01, 0.0, hint=rate)
                    self.faster.on_update(self._locked(lambda: self._steer("faster", self.faster.value)))
                if run.scene.controller.heading_control:
                    rate, most = f"by {np.degrees(TURN_RATE):g} degrees in each second", float(np.degrees(FARTHEST))
                    self.turned = gui.add_slider("turn, degrees", -most, most, 1.0, 0.0, hint=rate)
                    self.turned.on_update(self._locked(lambda: self._steer("turned", np.radians(self.turned.value))))
        if not run.parameters:
            return
        groups = list(dict.fromkeys(_group(parameter) for parameter in run.parameters))
        with gui.add_folder("Parameters", expand_by_default=len(run.parameters) > FEW):
            if len(run.parameters) > FEW:
                menu = gui.add_dropdown("of", groups, initial_value=groups[0])
                menu.on_update(lambda _: self._show_group(menu.value))
            for index, parameter in enumerate(run.parameters):
                self._add_slider(index, parameter, len(run.parameters) <= FEW or _group(parameter) == groups[0])

    def _add_command(self, name: str) -> None:
        one = self.run.scene.commands[name]
        if not one.max > one.min:
            return
        slider = self.server.gui.add_slider(
            whole(name) + (f", {whole(one.unit)}" if one.unit else ""), float(one.min), float(one.max),
            (one.max - one.min) / STEPS, one.asked, hint=whole(one.description) or None,
        )  # fmt: skip
        slider.on_update(self._locked(lambda: self.run.asked.update({name: float(slider.value)})))
        self.commands[name] = slider

    def _add_slider(self, index: int, parameter: Parameter, visible: bool) -> None:
        low, high = float(parameter.min), float(parameter.max)
        step = parameter.step if parameter.step > 0.0 else (high - low) / STEPS
        if not high > low:
            return
        unit = f", {parameter.unit}" if parameter.unit else ""
        slider = self.server.gui.add_slider(
            whole(parameter.name).removeprefix(_group(parameter)).strip(".") + unit, low, high, step,
            float(parameter.value), hint=whole(parameter.name), visible=visible,
        )  # fmt: skip
        slider.on_update(self._locked(lambda: self._set(index, slider.value)))
        self.parameters[parameter.name] = slider

    def _show_group(self, group: str) -> None:
        for parameter in self.run.parameters:
            if parameter.name in self.parameters:
                self.parameters[parameter.name].visible = _group(parameter) == group

    def _set(self, index: int, value: float) -> None:
        self.run.values[index] = value
        self._changed = True

    def _steer(self, what: str, value: float) -> None:
        setattr(self.run, what, value)  # a ramp leads there

    def _locked(self, *actions: Callable[[], None]) -> Callable[[Any], None]:
        """A callback that does these one after the other, undisturbed."""

        def called(_: Any) -> None:
            with self.lock:
                for action in actions:
                    action()

        return called

    def play(self, on: bool) -> None:
        """Run or pause."""
        self.playing = on
        self.play_button.label = "Pause" if on else "Run"

    def _advance(self, passed: float) -> None:
        if self._changed:
            self._changed = False
            self.run.apply()
        if not self.playing:
            return
        if self.run.status == Status.RUNNING:
            self._ended = 0.0
            self.run.advance(passed * self.speed)
        elif self.again.value:
            self._ended += passed
            if self._ended > PAUSE_AFTER_FALL or self.run.status == Status.COMPLETED:
                self.run.restart()
        self._show()

    def _show(self) -> None:
        self.track = self.run.track()
        if self.run.scene.commands:
            self.stage.move_ground(self.run.numeric.ground)
        self.stage.show([self.track], [0])
        self.pictures += 1
        now = time.monotonic()
        if now > self._arrow_until:
            self._remove_arrow()
        if now - self._refreshed > REFRESH:
            self._refreshed = now
            self._show_past()

    def _show_past(self) -> None:
        """Bring path, plots and text up to now."""
        window, r = self.run.track(SEEN), self.track.recording
        self.stage.extend_path([window])
        self.plots.replace(panels_of(window.recording, self.run.numeric), window.recording.time)
        self.plots.show(float(window.recording.time[-1]))
        status, speed = self.run.status, float(window.recording.com_velocity[:, 2].mean())
        word = "" if status == Status.RUNNING else f", {status.meaning}"
        self.text.content = f"{float(r.time[-1]):.1f} s, {speed:.2f} m/s over {SEEN:g} s{word}"


def _group(parameter: Parameter) -> str:
    """What a parameter belongs to: its name without the last word and the numbers behind it."""
    words = parameter.name.split(".")
    while words and words[-1].isdigit():
        words.pop()
    return whole(".".join(words[:-1]))
