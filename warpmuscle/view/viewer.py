"""A viser server that shows bipeds, and the controls that replays and live simulations have in common."""

from __future__ import annotations

import contextlib
import io
import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from warpmuscle.core.array_types import Floats
from warpmuscle.core.errors import Error
from warpmuscle.scene import Ground
from warpmuscle.view.access import access_to
from warpmuscle.view.curves import Panel
from warpmuscle.view.guard import Guard, GuardedHost, guarding
from warpmuscle.view.lanes import camera_of, lanes
from warpmuscle.view.packing import whole
from warpmuscle.view.plots import Plots
from warpmuscle.view.stage import SHOWN, Stage
from warpmuscle.view.track import Track

PICTURES = 40.0  # a second, at most


def new_server(host: str, port: int, title: str) -> Any:
    """A viser server at a port or the next free one, any if 0, behind a `Guard`, which it has as `guard`.

    Raises:
        Error: viser is missing or of a version that cannot be guarded, or nothing can listen at the host.
    """
    try:
        import viser
    except ImportError:
        raise Error(
            "the viewer needs viser: pip install 'warpmuscle[view]'; --export writes a page without it"
        ) from None
    guard, place = Guard(access_to(host)), GuardedHost(host)
    with contextlib.redirect_stdout(io.StringIO()):  # it prints its address in a box
        with guarding(guard, place, f"viser-v{viser.__version__}"):
            server = viser.ViserServer(host=place, port=port, label=whole(title), verbose=False)
        if not guard.installed or not hasattr(server.gui, "_gui_input_handle_from_uuid"):
            server.stop()
            raise Error(f"viser {viser.__version__} cannot be guarded against other pages: pip install 'viser<1.2'")
    guard.server, server.guard = server, guard
    server.gui.configure_theme(show_logo=False, show_share_button=False, brand_color=(0, 114, 178))
    server.gui.main_panel.dock_right()
    server.gui.main_panel.set_width(380)
    return server


class Viewer:
    """A server with a stage, driven by a thread of its own.

    Subclasses make controls before `_make_common`, and give tracks and frames in `_advance`.
    """

    def __init__(self, server: Any, tracks: Sequence[Track], ground: Ground) -> None:
        self.server = server
        self.offsets: Floats = lanes(len(tracks))
        self.stage = Stage(server, tracks, self.offsets, ground)
        self.pictures = 0  # shown so far
        self.lock = threading.RLock()  # callbacks come from threads of the server
        self._stopped = threading.Event()
        self._failure: BaseException | None = None
        self._thread = threading.Thread(target=self._loop, daemon=True)
        self.toggles: dict[str, Any] = {}
        self._set_camera(tracks)

    def _set_camera(self, tracks: Sequence[Track]) -> None:
        height = float(np.mean([track.recording.com[0, 1] for track in tracks]))
        distance, yaw, pitch = camera_of(self.offsets)
        way = np.array([np.sin(yaw) * np.cos(pitch), np.sin(pitch), np.cos(yaw) * np.cos(pitch)])
        camera = self.server.initial_camera
        camera.look_at = (0.0, height - 0.1, 0.0)
        camera.position = tuple(np.array([0.0, height - 0.1, 0.0]) + distance * way)
        camera.fov = 0.7

    def _make_common(self, panels: Sequence[Panel], time_of: Floats, on_change: Callable[[], None]) -> None:
        """Make the switches of what is shown, and the plots."""
        gui = self.server.gui
        with gui.add_folder("Show"):
            for name, on in SHOWN.items():
                if name not in ("follow", "shadows") and not self.stage.handles[name]:
                    continue
                box = gui.add_checkbox(name, on)
                box.on_update(self._on_toggle(name, box, on_change))
                self.toggles[name] = box
        with gui.add_folder("Plots"):
            self.plots = Plots(gui, panels, time_of)

    def _on_toggle(self, name: str, box: Any, on_change: Callable[[], None]) -> Callable[[Any], None]:
        def changed(_: Any) -> None:
            with self.lock:
                self.stage.toggle(name, box.value)
                on_change()

        return changed

    @property
    def url(self) -> str:
        """Where a browser of this machine finds it; with the token where others can reach it, too."""
        host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(self.server.get_host(), self.server.get_host())
        token = self.server.guard.access.token
        place = f"[{host}]" if ":" in host else host
        return f"http://{place}:{self.server.get_port()}" + (f"/?token={token}" if token else "")

    def start(self) -> None:
        """Begin to move."""
        self._thread.start()

    def stop(self) -> None:
        """End it all; the address answers no more."""
        self._stopped.set()
        if self._thread.is_alive() and self._thread is not threading.current_thread():
            self._thread.join()
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()

    def wait(self) -> None:
        """Return when it has been stopped; raises what went wrong meanwhile."""
        while not self._stopped.wait(0.2):
            pass
        if self._failure is not None:
            raise self._failure

    def _loop(self) -> None:
        last = time.perf_counter()
        while not self._stopped.is_set():
            now = time.perf_counter()
            try:
                with self.lock:
                    self._advance(now - last)
            except Exception as failure:
                self._failure = failure
                self._stopped.set()
            last = now
            self._stopped.wait(max(0.0, 1.0 / PICTURES - (time.perf_counter() - now)))

    def _advance(self, passed: float) -> None:
        """Go on by a wall time, s."""
        raise NotImplementedError
