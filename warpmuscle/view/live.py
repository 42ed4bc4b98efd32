"""A simulation that the page shows in real time, that can be pushed, and whose numbers have sliders."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.core.status import Status
from warpmuscle.view.content import curve_arrays, moving_content, track_arrays
from warpmuscle.view.controls import Button, Choice, Control, Slider, Toggle, for_page, use
from warpmuscle.view.curves import panels_of
from warpmuscle.view.editing.parameters import ParameterSliders
from warpmuscle.view.editor import ASKS, Editor
from warpmuscle.view.live_run import FARTHEST, FASTEST, SPEED_RATE, TURN_RATE, LiveRun, can_change_speed
from warpmuscle.view.messages import Edit, Heard, Pushed, Used, read_edit, read_message, read_push
from warpmuscle.view.page import ground_content, page_of
from warpmuscle.view.server import PROTOCOL, Message, PageServer
from warpmuscle.view.track import Track
from warpmuscle.view.viewer import Viewer

PICTURES = 30.0  # a second, that pages are sent new frames
SEEN = 10.0  # s of the motion that a page keeps
SPEEDS = ("0.1", "0.25", "0.5", "1", "2", "4")
REFRESH = 0.4  # s of wall time between two words about how it goes
PAUSE_AFTER_FALL = 1.0  # s of wall time before it starts again
HARDEST = 100.0  # N s of a push
FELLS = 5.0  # s of the motion, within which a push counts as what felled it
DIRECTIONS = {"forwards": 0.0, "to the left": 90.0, "backwards": 180.0, "to the right": -90.0}  # degrees


class Live(Viewer):
    """Runs a scene; what its controls say counts at once.

    Attributes:
        controls: all of them, which pages know by their places here.
        editor: what was changed of the scene's numbers and curves; None where a policy moves the body.
        pushes: impulses given so far, N s. pictures: how often pages were sent new frames.
    """

    def __init__(
        self, run: LiveRun, controls: Sequence[Control] = (), host: str = "127.0.0.1", port: int = 8080,
        server: PageServer | None = None,
    ) -> None:  # fmt: skip
        """Show a run.

        Args:
            server: that shows another page so far; by default a new one at the host and the port.
            controls: of others, such as sliders of commands; their functions are called by the thread that advances
                the run, between two steps.

        Raises:
            Error: as `PageServer` does.
        """
        self.run, self.playing, self.speed, self.again = run, True, 1.0, True
        self.lock = threading.RLock()
        self.pushes: list[Floats] = []
        self.pictures = 0
        self._sliders = ParameterSliders(run.scene, run.parameters, self._set_number)
        self.parameters = self._sliders.sliders
        self.editor = None if run.given is None else Editor(run.given)
        self._epoch, self._sent_until = 0, -1.0
        self._asked: list[Edit] = []  # what pages want to have of the scene as it is
        self._heard, self._edited = Heard(), False  # the latter: pages wait to be told what came of an edit
        self._refreshed = self._ended = 0.0
        self._ground = ground_content(run.numeric)  # that pages know
        self._pushed: tuple[float, str] | None = None  # s at the last push since the start, and its words
        self._fate = ""  # how the motion before this one ended
        self._waiting: list[Used | Edit | Pushed] = []  # what pages have sent since the last step
        self.bar = self._bar()
        self.commands = {name: self._command(name) for name, one in run.scene.commands.items() if one.max > one.min}
        self.controls: list[Control] = [*self.bar.values(), *self.commands.values(), *controls]
        self.controls += [*self._push_controls(), *self._steering()]
        self.controls += [*self.parameters.values(), self._again()]
        page = self._page(run.track()).encode()
        super().__init__(PageServer(host, port, page) if server is None else server)
        self.server.on_message = self._hear
        self.server.show(page, self._opening)
        self._thread = threading.Thread(target=self._loop, daemon=True)

    def _page(self, first: Track) -> str:
        known = {
            "protocol": PROTOCOL,
            "order": [[name, int(values[0].size)] for name, values in self._arrays(first).items()],
            "window": SEEN,
            "hardest": HARDEST,
            "controls": for_page(self.controls),
            "bar": {name: self.controls.index(control) for name, control in self.bar.items()},
            "edits": None if self.editor is None else self.editor.for_page(),
        }
        return page_of([first], [self.run.numeric], f"{self.run.scene.name}, live", True, True, live=known)

    def _bar(self) -> dict[str, Control]:
        """What the page has in its bar rather than in a section."""
        return {
            "play": Toggle("play", True, self.play),
            "speed": Choice("speed", SPEEDS, "1", lambda value: setattr(self, "speed", float(value))),
            "step": Button("one frame on", lambda _: self._step()),
            "again": Button("start again", lambda _: self.restart()),
        }

    def _push_controls(self) -> list[Control]:
        self.impulse = Slider("impulse", 0.0, HARDEST, 20.0, unit="N s", section="Push", step=1.0)
        self.direction = Choice("direction", list(DIRECTIONS), "to the left", section="Push")
        return [Button("Push", lambda _: self._push(), section="Push"), self.impulse, self.direction]

    def _push(self) -> None:
        impulse = self.run.push(self.impulse.value, np.radians(DIRECTIONS[self.direction.value]))
        self._was_pushed(impulse, f"{self.impulse.value:g} N s {self.direction.value}")

    def _push_by_hand(self, push: Pushed) -> None:
        impulse = np.array(push.push, dtype=np.float64)
        size = float(np.linalg.norm(impulse))
        impulse *= min(1.0, HARDEST / max(size, 1e-9))
        self.run.push_by(impulse)
        self._was_pushed(impulse, f"{min(size, HARDEST):.0f} N s by hand")

    def _was_pushed(self, impulse: Floats, words: str) -> None:
        self.pushes.append(impulse)
        self._pushed = self.run.time, words
        self._tell({"push": impulse.tolist()})

    def _command(self, name: str) -> Slider:
        one = self.run.scene.commands[name]

        def ask(value: float) -> None:
            self.run.asked[name] = value  # a ramp leads there

        return Slider(name, float(one.min), float(one.max), float(one.asked), ask, one.unit, one.description)

    def _steering(self) -> list[Control]:
        found: list[Control] = []
        controller, commands = self.run.scene.simbicon, self.run.scene.commands
        if controller is not None and can_change_speed(self.run.numeric.simbicon) and "speed" not in commands:
            hint = f"by {SPEED_RATE:g} m/s in each second"
            self.faster = Slider("faster", -FASTEST, FASTEST, 0.0, self._go_faster, "m/s", hint, "Steer", step=0.01)
            found.append(self.faster)
        if controller is not None and controller.heading_control:
            hint, most = f"by {np.degrees(TURN_RATE):g} degrees in each second", float(np.degrees(FARTHEST))
            self.turned = Slider("turn", -most, most, 0.0, self._turn, "degrees", hint, "Steer", step=1.0)
            found.append(self.turned)
        return found

    def _go_faster(self, value: float) -> None:
        self.run.faster = value  # a ramp leads there

    def _turn(self, value: float) -> None:
        self.run.turned = float(np.radians(value))

    def _set_number(self, name: str, value: float) -> None:
        if self.editor is not None:
            self.editor.set_number(name, value)

    def _again(self) -> Toggle:
        return Toggle("again after a fall", True, lambda on: setattr(self, "again", on), section="Simulation")

    def play(self, on: bool) -> None:
        """Run or pause."""
        self.playing = on

    def restart(self) -> None:
        """Back to the start."""
        with self.lock:
            self.run.restart()
            self._pushed, self._fate = None, ""
            self._epoch += 1
            self._sent_until = -1.0

    def _step(self) -> None:
        self.playing = self.bar["play"].value = False
        self.run.step()

    def start(self) -> None:
        """Begin to move."""
        self._thread.start()

    def stop(self) -> None:
        """End it all; the address answers no more."""
        self._stopped.set()
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join()
        super().stop()

    def _loop(self) -> None:
        last = time.perf_counter()
        while not self._stopped.is_set():
            now = time.perf_counter()
            try:
                with self.lock:
                    self._use_waiting()
                    self.advance(now - last)
            except Exception as failure:
                self._failure = failure
                self._stopped.set()
            last = now
            self._stopped.wait(max(0.0, 1.0 / PICTURES - (time.perf_counter() - now)))

    def _hear(self, raw: Message) -> None:
        """Note what a page sends, to be done between two steps."""
        message = read_message(raw, len(self.controls)) or read_edit(raw) or read_push(raw)
        if message is not None and self._takes(message):
            self._waiting.append(message)
            return
        if message is not None:
            self._heard.note(message)
        self.server.guard.tell("message", "no control of the viewer sends such a one")

    def _takes(self, message: Used | Edit | Pushed) -> bool:
        if isinstance(message, Edit):
            return self.editor is not None and self.editor.takes(message)
        return isinstance(message, Pushed) or self.controls[message.control].bounded(message.value) is not None

    def _use_waiting(self) -> None:
        waiting, self._waiting = self._waiting, []
        values: dict[int, Any] = {}
        for message in waiting:
            self._heard.note(message)
            if isinstance(message, Edit):
                self._use_edit(message)
            elif isinstance(message, Pushed):
                self._push_by_hand(message)
            else:
                control = self.controls[message.control]
                taken = use(control, message.value)
                if taken is not None and not isinstance(control, Button):
                    values[message.control] = taken
        if values:
            self._tell({"values": values})

    def _use_edit(self, edit: Edit) -> None:
        assert self.editor is not None
        self._edited = True
        if edit.edit in ASKS:
            self._asked.append(edit)
        if why := self.editor.use(edit):
            self._tell({"refused": why, "edits": self.editor.values()})

    def _follow_edits(self) -> None:
        """Let the simulation have what was edited since the last step, and tell pages how all numbers are now."""
        editor = self.editor
        if editor is not None and editor.pending:
            why, parts = {}, ("controller",) if editor.only_controller() else None
            try:
                scene = editor.make()
                self.run.use(scene, parts)
                editor.accept(scene)
            except Error as error:
                editor.refuse()
                why = {"refused": str(error)}
            if parts is None:
                self._tell({"doll": moving_content(self.run.track().doll, self.run.numeric)})
            self._tell({**why, "edits": editor.values(), "values": self._parameter_values(editor)})
        elif editor is not None and self._edited:
            self._tell({"edits": editor.values()})
        self._edited = False
        asked, self._asked = self._asked, []
        if editor is not None:
            for edit in {(one.edit, one.target): one for one in asked}.values():
                self._tell(editor.answer(edit))

    def _parameter_values(self, editor: Editor) -> dict[int, float]:
        """Values of the parameters' sliders, by number."""
        self._sliders.follow(editor.parameters())
        return {self.controls.index(slider): slider.value for slider in self.parameters.values()}

    def advance(self, passed: float) -> None:
        """Go on by a wall time, s, and tell pages; the viewer's own thread does so once it was started."""
        self._follow_edits()
        if self.playing:
            if self.run.status == Status.RUNNING:
                self._ended = 0.0
                self.run.advance(passed * self.speed)
            else:
                self._end(passed)
        self._tell_frames()

    def _end(self, passed: float) -> None:
        """Say once how the motion ended, and begin anew after a while; what was said stays to be read."""
        fate = self._ending()
        if not self._ended:
            self._tell({"status": fate})
        self._ended += max(passed, 1e-9)
        if self.again and (self._ended > PAUSE_AFTER_FALL or self.run.status == Status.COMPLETED):
            self.restart()
            self._fate = f"{fate}; begun anew"

    def _ending(self) -> str:
        """How the motion ended, when, and by which push, if one came just before."""
        words = f"{self.run.status.word} at {self.run.time:.1f} s"
        if self.run.status == Status.COMPLETED or self._pushed is None or self.run.time - self._pushed[0] > FELLS:
            return words
        return f"{words}, pushed by {self._pushed[1]}"

    def _tell_frames(self) -> None:
        """Tell pages of the frames since the last time."""
        if self.run.time <= self._sent_until:
            return
        track = self.run.track(min(max(self.run.time - self._sent_until, 0.0), SEEN))
        recent = track.recording.time > self._sent_until
        if not np.any(recent):
            return
        rows = self._rows(track)[recent]
        self._sent_until = float(track.recording.time[-1])
        self.server.tell(np.concatenate([[self._epoch], rows.ravel()]).astype("<f4").tobytes())
        self.pictures += 1
        now = time.monotonic()
        if now - self._refreshed > REFRESH:
            self._refreshed = now
            ground = ground_content(self.run.numeric) if self.commands else self._ground
            news = {"ground": ground} if ground != self._ground else {}
            self._ground = ground
            self._tell({"status": self._words(track), **news})

    def _rows(self, track: Track) -> Floats:
        """All numbers of frames (F, N), in the order that the page knows."""
        values = self._arrays(track).values()
        return np.concatenate([np.reshape(each, (track.frames, -1)) for each in values], axis=1)

    def _arrays(self, track: Track) -> dict[str, Floats]:
        """What the page is sent about each frame, by name; `moment` is the controller's state and its phase."""
        recording = track.recording
        panels = panels_of(recording, self.run.numeric, everything=True)
        arrays = {name: values for name, (values, _) in (track_arrays(track) | curve_arrays(panels)).items()}
        nothing = np.zeros(recording.frames)
        of_machine = [nothing] * 2 if self.run.scene.simbicon is None else [recording.state, recording.phase]
        return arrays | {"moment": np.column_stack(of_machine)}

    def _words(self, track: Track) -> str:
        if self.run.status != Status.RUNNING:
            return self._ending()
        speed = f"{track.recording.com_velocity[-1, 2]:.2f} m/s forwards"
        return f"{self._fate}; {speed}" if self._fate else speed

    def _opening(self) -> list[Message]:
        """What a page is sent when it opens: all values, and the last seconds."""
        with self.lock:
            values = {number: control.value for number, control in enumerate(self.controls)}
            track = self.run.track(SEEN)
            rows = self._rows(track)
            frames = np.concatenate([[self._epoch], rows.ravel()]).astype("<f4").tobytes()
            doll = moving_content(track.doll, self.run.numeric)
            ground = ground_content(self.run.numeric)
            edits = {} if self.editor is None else {"edits": self.editor.values()}
            known = {"values": values, "status": self._words(track), "doll": doll, "ground": ground, **edits}
            return [json.dumps(known | self._heard.for_page()), frames]

    def _tell(self, what: dict[str, Any]) -> None:
        self.server.tell(json.dumps(what | self._heard.for_page()))
