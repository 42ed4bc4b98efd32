"""A running viewer, and what a page, or something that is no page, says to it."""

from __future__ import annotations

import contextlib
import itertools
import json
import socket
from collections.abc import Iterator
from typing import Any, NamedTuple
from urllib.parse import parse_qs, urlsplit

import pytest

from patience import PATIENCE, until
from warpmuscle.formats import load
from warpmuscle.view.controls import Control
from warpmuscle.view.live import Live
from warpmuscle.view.live_run import LiveRun
from warpmuscle.view.server import PROTOCOL, PageServer

pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
from websockets import Subprotocol
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

# Have all that a page says from now on in a list, `told`: what is there for seconds only may be gone when one looks.
TOLD = """() => { const message = document.getElementById('message');
    window.told = [];
    new MutationObserver(() => told.push(message.textContent)).observe(message, { childList: true }); }"""

# Note in a page what marks it has heard, see `caught_up`.
MARKED = """(() => { const Plain = WebSocket;
    window.WebSocket = class extends Plain {
        set onmessage(act) { super.onmessage = (event) => {
            act.call(this, event);
            if (typeof event.data === "string") window.marked = JSON.parse(event.data).mark ?? window.marked; }; }
    }; })()"""
MARKS = itertools.count(1)


def caught_up(viewer: Live, page: Any) -> None:
    """Wait until a page of which `MARKED` is a script has heard all that it was told of what the viewer has done."""
    with viewer.lock:  # so that no step is half done, of which it is yet to be told
        mark = next(MARKS)
        viewer.server.tell(json.dumps({"mark": mark}))
    until(lambda: page.evaluate("window.marked") == mark)


@contextlib.contextmanager
def running_viewer() -> Iterator[Live]:
    """A walk, live, for as long as it is needed."""
    viewer = Live(LiveRun(load("fwalk")), port=0)
    viewer.start()
    yield viewer
    viewer.stop()
    viewer.wait()  # raises what ended it


class Place(NamedTuple):
    """Where a viewer is found, and with what token; "" for none."""

    port: int
    token: str

    def target(self, target: str) -> str:
        """What is asked for there."""
        return f"{target}{'&' if '?' in target else '?'}token={self.token}" if self.token else target


def port_of(viewer: Live) -> int:
    return viewer.server.port


def place_of(viewer: Live | PageServer) -> Place:
    """The place that the printed address names."""
    found = urlsplit(viewer.url)
    assert found.port is not None
    return Place(found.port, parse_qs(found.query)["token"][0])


def page_socket(place: Place, host: str = "127.0.0.1", origin: str | None = "", target: str = "/") -> ClientConnection:
    """What a page opens; by default the viewer's own one."""
    own = f"http://{host}:{place.port}" if origin == "" else origin
    raw = socket.create_connection(("127.0.0.1", place.port), timeout=PATIENCE)
    return connect(
        f"ws://{host}:{place.port}{place.target(target)}", sock=raw, origin=own, proxy=None,
        subprotocols=[Subprotocol(PROTOCOL)],
        compression=None, max_size=None, max_queue=None, open_timeout=PATIENCE, close_timeout=0.1,
    )  # fmt: skip


def answer(place: Place, *lines: str, target: str = "/") -> str:
    """What a viewer says to a plain request with these header lines."""
    with socket.create_connection(("127.0.0.1", place.port), timeout=PATIENCE) as raw:
        raw.sendall("\r\n".join([f"GET {place.target(target)} HTTP/1.1", *lines, "", ""]).encode("latin-1"))
        parts = []
        with contextlib.suppress(ConnectionResetError):
            while part := raw.recv(1 << 16):
                parts.append(part)
    return b"".join(parts).decode("latin-1")


def ended(client: ClientConnection) -> str:
    """Why the other side closes a connection."""
    with pytest.raises(ConnectionClosed) as closed:
        list(iter(lambda: client.recv(timeout=PATIENCE), None))
    return str(closed.value)


def used(live: Live, control: Control, value: Any) -> str:
    """The message of a control, as the page sends it."""
    number = next(k for k, one in enumerate(live.controls) if one is control)
    return json.dumps({"control": number, "value": value})


def nobody_listens(viewer: Live) -> None:
    """Wait until the server knows that pages are closed."""
    until(lambda: viewer.server.clients == 0)


def still_serves(viewer: Live) -> None:
    """The page is there, its socket brings pictures, and the biped walks on."""
    place = place_of(viewer)
    assert answer(place, f"Host: 127.0.0.1:{place.port}").startswith("HTTP/1.1 200")
    with page_socket(place) as client:
        assert len(client.recv(timeout=PATIENCE)) > 1000
        shown = viewer.pictures
        until(lambda: viewer.pictures > shown + 2)
    nobody_listens(viewer)
    if not viewer.playing:
        viewer.play(True)
    before = viewer.run.time
    until(lambda: viewer.run.time != before)


def moved_by(viewer: Live) -> tuple[Any, ...]:
    """All that a page can change of the motion."""
    run = viewer.run
    hip = run.rollout.model.simbicon.hip.numpy().tolist()
    return len(viewer.pushes), run.faster, run.turned, run.values.tolist(), hip, viewer.playing, viewer.speed
