"""A running viewer is sent what no page would send, and serves on."""

import contextlib
import json
import os
import random
import re
import signal
import socket
import struct
import subprocess
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from child_signals import PROGRAM, running
from live_viewer import (
    PATIENCE,
    Place,
    answer,
    ended,
    moved_by,
    page_socket,
    place_of,
    running_viewer,
    still_serves,
    until,
    used,
)
from patience import for_a_moment
from warpmuscle.view.live import Live
from warpmuscle.view.live_run import TURN_RATE
from warpmuscle.view.messages import LARGEST
from warpmuscle.view.server import BEHIND, PROTOCOL

pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
from websockets.exceptions import ConnectionClosed, InvalidHandshake, InvalidStatus
from websockets.sync.client import connect


@pytest.fixture(scope="module")
def live() -> Iterator[Live]:
    with running_viewer() as viewer:
        yield viewer


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
    place, before = place_of(live), moved_by(live)
    speed = live.bar["speed"]
    with page_socket(place) as client:
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


@contextlib.contextmanager
def deaf_page(place: Place) -> Iterator[None]:
    """A page whose socket is open, and that never reads from it."""
    asks = [f"GET {place.target('/')} HTTP/1.1", f"Host: 127.0.0.1:{place.port}", f"Origin: http://127.0.0.1:{place.port}",
            "Upgrade: websocket", "Connection: Upgrade", "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", f"Sec-WebSocket-Protocol: {PROTOCOL}", "", ""]  # fmt: skip
    with socket.create_connection(("127.0.0.1", place.port), timeout=PATIENCE) as raw:
        raw.sendall("\r\n".join(asks).encode())
        assert raw.recv(12) == b"HTTP/1.1 101"
        yield


def test_a_page_that_does_not_listen_costs_no_memory(live):
    with deaf_page(place_of(live)):
        until(lambda: live.server.clients > 0)
        connection = next(iter(live.server._clients))
        live.server.tell(bytes(40 << 20))  # more than the machine's buffers hold
        until(lambda: connection.transport.get_write_buffer_size() > BEHIND)
        shown, waiting = live.pictures, connection.transport.get_write_buffer_size()
        until(lambda: live.pictures > shown + 20)
        # Words, which it does not miss, are short; each of these pictures is longer than that, see `still_serves`.
        assert connection.transport.get_write_buffer_size() < waiting + 20 * 1000
    still_serves(live)


def test_values_of_a_page_are_bounded_and_steering_is_a_ramp(live):
    first = next(iter(live.parameters))
    slider = live.parameters[first]
    index = [parameter.name for parameter in live.run.parameters].index(first)
    usual = slider.value
    with page_socket(place_of(live)) as client:
        until(lambda: live.server.clients > 0)
        client.send(used(live, slider, 1e308))
        until(lambda: live.run.values[index] == slider.max == slider.value)
        client.send(used(live, slider, usual))
        until(lambda: live.run.values[index] == usual)
        client.send(used(live, live.impulse, -1e308))
        until(lambda: live.impulse.value == 0.0)
        client.send(used(live, live.impulse, 20))
        live.restart()  # else pages are sent nothing until the motion is where it was
        client.send(used(live, live.turned, 60))
        until(lambda: live.run.turned == pytest.approx(np.radians(60.0)))
        for _ in range(20):
            with live.lock:
                heading, now = live.run.rollout.model.simbicon.hip.numpy()["desired_heading"][0, 0], live.run.time
            assert heading <= TURN_RATE * now + 1e-6
            for_a_moment()
        until(lambda: live.run.rollout.model.simbicon.hip.numpy()["desired_heading"][0, 0] > 0.05)
        client.send(used(live, live.turned, 0))
        until(lambda: live.run.turned == 0.0)
    live.restart()  # else its heading is on the way back while another test looks
    still_serves(live)


def test_broken_connections_and_frames_do_no_harm(live):
    place = place_of(live)
    port = place.port
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
        with page_socket(place) as client:
            client.socket.sendall(frame)
            assert re.search("100[29]", ended(client))
    with page_socket(place) as client:
        with contextlib.suppress(ConnectionClosed):
            client.send(bytes(LARGEST + 1))
        assert "1009" in ended(client)
    for _ in range(5):
        page_socket(place).socket.close()  # gone without a word
    with pytest.raises(InvalidHandshake):
        connect(
            f"ws://127.0.0.1:{port}{place.target('/')}", origin=f"http://127.0.0.1:{port}", proxy=None
        )  # of no version of the page
    still_serves(live)


@contextlib.contextmanager
def command_line(folder: Path) -> Iterator[subprocess.Popen[str]]:
    """The viewer as a command, killed at the latest when it is no longer needed."""
    command = [*PROGRAM, "view", "fwalk", "--live", "--no-open"]
    given = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": folder}
    with running(command, env=os.environ | {"PYTHONUNBUFFERED": "1"}, **given) as run:
        yield run


def test_garbage_does_not_fill_the_terminal(tmp_path):
    with command_line(tmp_path) as run:
        said = run.stdout.readline()
        found = re.match(r"http://127\.0\.0\.1:(\d+)/\?token=([\w-]{20,})  \(Ctrl-C ends it\)", said)
        assert found, said
        place = Place(int(found[1]), found[2])
        for _ in range(20):
            with pytest.raises(InvalidStatus):
                page_socket(place, origin="http://evil.example")
            answer(place, "Host: \x1b[2J[red]evil.example")
            with socket.create_connection(("127.0.0.1", place.port)) as raw:
                raw.sendall(b"\x00" * 1000 + b"\r\n\r\n")
        with page_socket(place) as client:
            for message in ["text", b"\xc1", b"", '{"control": 0, "value": {}}'] * 250:
                client.send(message)
            assert client.ping().wait(PATIENCE)
        with page_socket(place) as client:
            while len(client.recv(timeout=PATIENCE)) <= 1000:  # words, while the motion is made ready
                pass
        run.send_signal(signal.SIGINT)
        out, errors = run.communicate(timeout=PATIENCE)
    assert (run.returncode, out) == (130, "")
    told = [line for line in errors.splitlines() if "viewer" in line or "Traceback" in line]
    assert sorted(line.split(":")[0] for line in told) == [
        "the viewer refused a message",
        "the viewer refused a request",
    ]
    waited = [line for line in errors.splitlines() if re.search(r", \d+ s$", line)]  # on a slow machine
    assert len(errors.splitlines()) - len(waited) < 20  # of which Warp says most
    assert errors.replace("\n", "").isprintable()
