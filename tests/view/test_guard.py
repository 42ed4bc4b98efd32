"""A running viewer attacked: by pages of other origins in a real browser, and by messages that no page would send."""

import contextlib
import functools
import http.server
import json
import os
import random
import re
import signal
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from warpmuscle.formats import load
from warpmuscle.view.controls import Control
from warpmuscle.view.live import Live
from warpmuscle.view.live_run import TURN_RATE, LiveRun
from warpmuscle.view.messages import LARGEST
from warpmuscle.view.server import PROTOCOL

pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
from websockets import Subprotocol
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus
from websockets.sync.client import ClientConnection, connect

PATIENCE = 60.0  # s, on a busy machine


@pytest.fixture(scope="module")
def live() -> Iterator[Live]:
    viewer = Live(LiveRun(load("fwalk")), port=0)
    viewer.start()
    yield viewer
    viewer.stop()
    viewer.wait()  # raises what ended it


def port_of(viewer: Live) -> int:
    return viewer.server.port


def page_socket(port: int, host: str = "127.0.0.1", origin: str | None = "", target: str = "/") -> ClientConnection:
    """What a page opens; by default the viewer's own one."""
    own = f"http://{host}:{port}" if origin == "" else origin
    raw = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
    return connect(
        f"ws://{host}:{port}{target}", sock=raw, origin=own, subprotocols=[Subprotocol(PROTOCOL)], proxy=None,
        compression=None, max_size=None, max_queue=None, open_timeout=PATIENCE, close_timeout=0.1,
    )  # fmt: skip


def answer(port: int, *lines: str, target: str = "/") -> str:
    """What the port says to a plain request with these header lines."""
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as raw:
        raw.sendall("\r\n".join([f"GET {target} HTTP/1.1", *lines, "", ""]).encode("latin-1"))
        parts = []
        with contextlib.suppress(ConnectionResetError):
            while part := raw.recv(1 << 16):
                parts.append(part)
    return b"".join(parts).decode("latin-1")


def until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it never came to that"
        time.sleep(0.05)


def ended(client: ClientConnection) -> str:
    """Why the other side closes a connection."""
    with pytest.raises(ConnectionClosed) as closed:
        list(iter(lambda: client.recv(timeout=PATIENCE), None))
    return str(closed.value)


def used(live: Live, control: Control, value: Any) -> str:
    """The message of a control, as the page sends it."""
    number = next(k for k, one in enumerate(live.controls) if one is control)
    return json.dumps({"control": number, "value": value})


def still_serves(viewer: Live) -> None:
    """The page is there, its socket brings pictures, and the biped walks on."""
    port = port_of(viewer)
    assert answer(port, f"Host: 127.0.0.1:{port}").startswith("HTTP/1.1 200")
    with page_socket(port) as client:
        assert len(client.recv(timeout=PATIENCE)) > 1000
        shown = viewer.pictures
        until(lambda: viewer.pictures > shown + 2)
    if not viewer.playing:
        viewer.play(True)
    before = viewer.run.time
    until(lambda: viewer.run.time != before)


def moved_by(viewer: Live) -> tuple[Any, ...]:
    """All that a page can change of the motion."""
    run = viewer.run
    hip = run.rollout.model.simbicon.hip.numpy().tolist()
    return len(viewer.pushes), run.faster, run.turned, run.values.tolist(), hip, viewer.playing, viewer.speed


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("127.0.0.1", "http://evil.example"), ("127.0.0.1", "http://127.0.0.1:1"), ("127.0.0.1", "null"),
        ("127.0.0.1", None), ("evil.example", ""), ("evil.example", "http://127.0.0.1:{port}"), ("localhost", "http://127.0.0.1:{port}"),
    ],
)  # fmt: skip
def test_a_socket_of_another_page_or_under_another_name_is_refused(live, host, origin):
    port = port_of(live)
    with pytest.raises(InvalidStatus, match="403"):
        page_socket(port, host, origin and origin.format(port=port))
    with pytest.raises(InvalidStatus, match="403"):
        page_socket(port, target="/?websocket=ws://evil.example")


def test_requests_under_another_name_or_from_another_page_get_nothing(live):
    port = port_of(live)
    own = f"Host: 127.0.0.1:{port}"
    whole = answer(port, own)
    assert whole.startswith("HTTP/1.1 200")
    for header in (
        "X-Frame-Options: DENY",
        "Cross-Origin-Resource-Policy: same-origin",
        "Referrer-Policy: no-referrer",
    ):
        assert header in whole
    for lines in (
        [f"Host: evil.example:{port}"], [own, "Origin: http://evil.example"], [own, own], ["Host:"], ["X: y"],
        [own, f"Origin: http://localhost:{port}"], [own, "Sec-Fetch-Site: cross-site"],
        [own, "Sec-Fetch-Site: same-site", "Sec-Fetch-Mode: navigate", "Sec-Fetch-Dest: iframe"],
    ):  # fmt: skip
        said = answer(port, *lines)
        assert said.startswith("HTTP/1.1 403"), said
        assert len(said) < 1000
    for target in ("/?websocket=ws://evil.example", "/?playbackPath=http://evil.example/x"):
        assert answer(port, own, target=target).startswith("HTTP/1.1 403")
    for target in ("/../../../etc/passwd", "/%2e%2e/%2e%2e/server.py", "/index.html", "//evil.example"):
        assert answer(port, own, target=target).startswith("HTTP/1.1 404")


class _Site(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_: Any) -> None:
        pass


@pytest.fixture
def foreign(tmp_path) -> Iterator[int]:
    """The port of another server of this machine."""
    handler = functools.partial(_Site, directory=str(tmp_path))
    (tmp_path / "index.html").write_text("<!DOCTYPE html><title>another page</title><body></body>")
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield server.server_address[1]
        server.shutdown()


ATTACK = """async ({ place, protocol, messages }) => {
  const got = [], until = (f, ms) => new Promise((done) => { f(done); setTimeout(() => done("nothing"), ms); });
  const note = (what, found) => { if (found !== "nothing") got.push(`${what}: ${found}`); };
  for (const mode of ["cors", "no-cors", "same-origin"])
    note(mode, await fetch(`http://${place}/`, { mode }).then(
      async (response) => response.type === "opaque" ? "nothing" : await response.text(), () => "nothing"));
  for (const kind of ["script", "img", "link"]) note(kind, await until((done) => {
    const made = document.createElement(kind);
    Object.assign(made, { src: `http://${place}/`, href: `http://${place}/`, rel: "stylesheet",
      onload: () => done("loaded"), onerror: () => done("nothing") });
    document.body.append(made);
  }, 3000));
  const frame = document.createElement("iframe");
  frame.src = `http://${place}/`;
  document.body.append(frame);
  note("socket", await until((done) => {
    const ws = new WebSocket(`ws://${place}/`, [protocol]);
    ws.binaryType = "arraybuffer";
    ws.onmessage = (event) => done(`${event.data.byteLength} bytes`);
    ws.onopen = () => { for (const message of messages) ws.send(message); };
    ws.onerror = () => done("nothing");
  }, 5000));
  return got;
}"""


@pytest.mark.parametrize(
    "site", ["http://127.0.0.1:{other}", "http://evil.localhost:{other}", "http://localhost:{other}"]
)
def test_a_page_of_another_origin_gets_nothing_and_moves_nothing(live, browser, foreign, site):
    port, page = port_of(live), browser.new_page()
    page.set_default_timeout(1000.0 * PATIENCE)
    page.goto(site.format(other=foreign))
    assert page.title() == "another page"
    push = next(control for control in live.controls if control.name == "Push")
    messages = [used(live, push, True), used(live, live.turned, 60.0)]
    before, clients = moved_by(live), live.server.clients
    # The last of these names leads here, as one does that was bound anew to this machine.
    for place in (f"127.0.0.1:{port}", f"localhost:{port}", f"rebound.localhost:{port}"):
        given = {"place": place, "protocol": PROTOCOL, "messages": messages}
        assert page.evaluate(ATTACK, given) == []
    assert not any(str(port) in frame.url and frame.title() for frame in page.frames[1:])
    page.goto(f"http://rebound.localhost:{port}/")
    assert page.inner_text("body").startswith("403")
    assert page.evaluate(ATTACK, {**given, "place": f"rebound.localhost:{port}"}) == [
        f"{mode}: {page.text_content('body')}" for mode in ("cors", "no-cors", "same-origin")
    ]
    page.goto(f"http://127.0.0.1:{port}/?websocket=ws://127.0.0.1:{foreign}/")
    assert page.inner_text("body").startswith("403")
    page.close()
    assert moved_by(live) == before
    assert live.server.clients == clients
    still_serves(live)


def garbage(chance: random.Random, live: Live) -> Iterator[str | bytes]:
    """1000 messages, none of which a page would send."""
    odd = [float("inf"), float("nan"), None, "x" * 2000, "no option", [], {}, [[1]], {"a": 1}]
    whole = used(live, live.turned, 30.0)
    count = len(live.controls)
    for number in range(1000):
        match number % 8:
            case 0:
                yield chance.randbytes(chance.randrange(0, 300))
            case 1:
                yield chance.choice(["", "text", "{}", '{"control":', "\x1b[2J[red]:100:", "null", "[]", '"a"'])
            case 2:
                yield json.dumps({"control": chance.randrange(count), "value": chance.choice(odd)})
            case 3:
                yield json.dumps(
                    {"control": chance.choice([-1, count, 1 << 70, 0.5, "__proto__", None, True]), "value": 1}
                )
            case 4:
                yield json.dumps({"control": 0, "value": True, chance.choice(["min", "name", "changed"]): 1e308})
            case 5:
                yield json.dumps({"type": "GuiUpdateMessage", "uuid": "x", "updates": {"value": 9.0}})
            case 6:
                yield whole[: chance.randrange(len(whole))]
            case _:
                yield chance.choice(["[" * 4000, '{"a":' * 700, b"\x91" * 4000, b"\x00" * 4000, "9" * 4000])


def test_a_thousand_malformed_messages_later_it_still_serves(live, caplog):
    port, before = port_of(live), moved_by(live)
    speed = live.bar["speed"]
    with page_socket(port) as client:
        for message in garbage(random.Random(4), live):
            client.send(message)
        client.send(used(live, speed, "2"))
        until(lambda: live.speed == 2.0)  # all that came before was read
        client.send(used(live, speed, "1"))
        until(lambda: live.speed == 1.0)
    assert moved_by(live) == before
    assert len([record for record in caplog.records if "message" in record.getMessage()]) <= 1
    assert not [record for record in caplog.records if record.name == "asyncio"]
    still_serves(live)


def test_a_page_that_does_not_listen_costs_no_memory(live):
    with page_socket(port_of(live)) as client:
        client.recv(timeout=PATIENCE)
        connection = next(iter(live.server._clients))
        shown = live.pictures
        live.server.tell(bytes(40 << 20))  # more than the machine's buffers hold
        until(lambda: live.pictures > shown + 20)
        waiting = connection.transport.get_write_buffer_size()
        shown = live.pictures
        until(lambda: live.pictures > shown + 20)
        assert connection.transport.get_write_buffer_size() <= waiting
    still_serves(live)


def test_values_of_a_page_are_bounded_and_steering_is_a_ramp(live):
    first = next(iter(live.parameters))
    slider = live.parameters[first]
    index = [parameter.name for parameter in live.run.parameters].index(first)
    usual = slider.value
    with page_socket(port_of(live)) as client:
        until(lambda: live.server.clients > 0)
        client.send(used(live, slider, 1e308))
        until(lambda: live.run.values[index] == slider.max == slider.value)
        client.send(used(live, slider, usual))
        until(lambda: live.run.values[index] == usual)
        client.send(used(live, live.impulse, -1e308))
        until(lambda: live.impulse.value == 0.0)
        client.send(used(live, live.impulse, 20))
        with live.lock:
            live.run.restart()
        client.send(used(live, live.turned, 60))
        until(lambda: live.run.turned == pytest.approx(np.radians(60.0)))
        for _ in range(20):
            with live.lock:
                heading, now = live.run.rollout.model.simbicon.hip.numpy()["desired_heading"][0, 0], live.run.time
            assert heading <= TURN_RATE * now + 1e-6
            time.sleep(0.05)
        until(lambda: live.run.rollout.model.simbicon.hip.numpy()["desired_heading"][0, 0] > 0.05)
        client.send(used(live, live.turned, 0))
        until(lambda: live.run.turned == 0.0)
    still_serves(live)


def test_broken_connections_and_frames_do_no_harm(live):
    port = port_of(live)
    start = f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n".encode()
    held = []
    for number in range(300):  # half open, more than are held at once
        raw = socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)
        raw.sendall(start if number % 2 else b"")
        held.append(raw)
    still_serves(live)
    for raw in held:
        raw.close()
    starts = [
        b"\x16\x03\x01\x02\x00\x01" + bytes(500), b"\x00" * 5000, b"GET " + b"/" * 100_000, b"POST / HTTP/1.1\r\n\r\n",
        b"\r\n" * 1000, start + b"X: " + b"y" * 20_000 + b"\r\n\r\n", start + b"\xff: \x1b[31m\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"a: b\r\n" * 5000 + b"\r\n",
    ]  # fmt: skip
    for said in starts:
        with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as raw:
            raw.sendall(said)
            raw.shutdown(socket.SHUT_WR)
            raw.recv(100)
    frames = [b"\xff" * 100, struct.pack("!BBQ", 0x82, 0xFF, 1 << 62) + bytes(4), b"\x82\x05plain"]
    for frame in frames:
        with page_socket(port) as client:
            client.socket.sendall(frame)
            assert re.search("100[29]", ended(client))
    with page_socket(port) as client:
        with contextlib.suppress(ConnectionClosed):
            client.send(bytes(LARGEST + 1))
        assert "1009" in ended(client)
    for _ in range(5):
        page_socket(port).socket.close()  # gone without a word
    with pytest.raises(InvalidHandshake):
        connect(f"ws://127.0.0.1:{port}/", origin=f"http://127.0.0.1:{port}", proxy=None)  # of no version of the page
    still_serves(live)


@contextlib.contextmanager
def command_line(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """The viewer as a command, killed at the latest when it is no longer needed."""
    command = [sys.executable, "-c", "from warpmuscle.cli import main; main()", "view", "fwalk", "--live", "--no-open"]
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": folder}
    with subprocess.Popen(command, env=os.environ | {"PYTHONUNBUFFERED": "1"}, **given) as run:
        try:
            yield run
        finally:
            run.kill()


def test_garbage_does_not_fill_the_terminal(tmp_path):
    with command_line(tmp_path) as run:
        said = run.stdout.readline()
        found = re.match(r"http://127\.0\.0\.1:(\d+)/  \(Ctrl-C ends it\)", said)
        assert found, said
        port = int(found[1])
        for _ in range(20):
            with pytest.raises(InvalidStatus):
                page_socket(port, origin="http://evil.example")
            answer(port, "Host: \x1b[2J[red]evil.example")
            with socket.create_connection(("127.0.0.1", port)) as raw:
                raw.sendall(b"\x00" * 1000 + b"\r\n\r\n")
        with page_socket(port) as client:
            for message in ["text", b"\xc1", b"", '{"control": 0, "value": {}}'] * 250:
                client.send(message)
            assert client.ping().wait(PATIENCE)
        with page_socket(port) as client:
            assert len(client.recv(timeout=PATIENCE)) > 1000
        run.send_signal(signal.SIGINT)
        out, errors = run.communicate(timeout=PATIENCE)
    assert (run.returncode, out) == (130, "")
    told = [line for line in errors.splitlines() if "viewer" in line or "Traceback" in line]
    assert sorted(line.split(":")[0] for line in told) == [
        "the viewer refused a message",
        "the viewer refused a request",
    ]
    assert len(errors.splitlines()) < 20  # of which Warp says most
    assert errors.replace("\n", "").isprintable()


def test_a_viewer_for_other_machines_opens_with_its_token_only(browser):
    viewer = Live(LiveRun(load("fwalk")), host="0.0.0.0", port=0)
    viewer.start()
    port = port_of(viewer)
    token = viewer.server.guard.access.token
    assert viewer.url == f"http://127.0.0.1:{port}/?token={token}"
    for lines in ([f"Host: 127.0.0.1:{port}"], [f"Host: machine.example:{port}"]):
        assert answer(port, *lines).startswith("HTTP/1.1 403")
        assert answer(port, *lines, target=f"/?token={token}").startswith("HTTP/1.1 200")
    with pytest.raises(InvalidStatus):
        page_socket(port)
    with pytest.raises(InvalidStatus):
        page_socket(port, origin="http://evil.example", target=f"/?token={token}")
    page = browser.new_page(viewport={"width": 400, "height": 400})
    page.set_default_timeout(1000.0 * PATIENCE)
    page.goto(viewer.url)
    until(lambda: viewer.server.clients == 1)  # by the cookie
    page.close()
    viewer.stop()


def test_other_servers_of_the_process_stay_as_they_are(live):
    from websockets.sync.server import serve

    def echo(connection: Any) -> None:
        connection.send(connection.recv())

    with serve(echo, "127.0.0.1", 0) as other:
        threading.Thread(target=other.serve_forever, daemon=True).start()
        with connect(f"ws://127.0.0.1:{other.socket.getsockname()[1]}", proxy=None) as client:
            client.send("as before")
            assert client.recv(timeout=PATIENCE) == "as before"
        other.shutdown()
