"""Who may talk to a running viewer: no page of another origin, in a real browser either, and none without a token."""

import functools
import http.server
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from live_viewer import (
    PATIENCE,
    Place,
    answer,
    moved_by,
    nobody_listens,
    page_socket,
    place_of,
    port_of,
    running_viewer,
    still_serves,
    until,
    used,
)
from warpmuscle.formats import load
from warpmuscle.view.guard import WITHOUT_TOKEN
from warpmuscle.view.live import Live
from warpmuscle.view.live_run import LiveRun
from warpmuscle.view.server import PROTOCOL

pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect


@pytest.fixture(scope="module")
def live() -> Iterator[Live]:
    with running_viewer() as viewer:
        yield viewer


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("127.0.0.1", "http://evil.example"), ("127.0.0.1", "http://127.0.0.1:1"), ("127.0.0.1", "null"),
        ("127.0.0.1", None), ("evil.example", ""), ("evil.example", "http://127.0.0.1:{port}"), ("localhost", "http://127.0.0.1:{port}"),
    ],
)  # fmt: skip
def test_a_socket_of_another_page_or_under_another_name_is_refused(live, host, origin):
    place = place_of(live)
    with pytest.raises(InvalidStatus, match="403"):
        page_socket(place, host, origin and origin.format(port=place.port))
    with pytest.raises(InvalidStatus, match="403"):
        page_socket(place, target="/?websocket=ws://evil.example")


def test_requests_under_another_name_or_from_another_page_get_nothing(live):
    place = place_of(live)
    port, own = place.port, f"Host: 127.0.0.1:{place.port}"
    whole = answer(place, own)
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
        said = answer(place, *lines)
        assert said.startswith("HTTP/1.1 403"), said
        assert len(said) < 1000
    for target in ("/?websocket=ws://evil.example", "/?playbackPath=http://evil.example/x"):
        assert answer(place, own, target=target).startswith("HTTP/1.1 403")
    for target in ("/../../../etc/passwd", "/%2e%2e/%2e%2e/server.py", "/index.html", "//evil.example"):
        assert answer(place, own, target=target).startswith("HTTP/1.1 404")


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
    page.goto(site.format(other=foreign))
    assert page.title() == "another page"
    push = next(control for control in live.controls if control.name == "Push")
    messages = [used(live, push, True), used(live, live.turned, 60.0)]
    nobody_listens(live)
    before = moved_by(live)
    # The last of these names leads here, as one does that was bound anew to this machine.
    for place in (f"127.0.0.1:{port}", f"localhost:{port}", f"rebound.localhost:{port}"):
        given = {"place": place, "protocol": PROTOCOL, "messages": messages}
        assert page.evaluate(ATTACK, given) == []
    assert not any(str(port) in frame.url and frame.title() for frame in page.frames[1:])
    page.goto(f"http://rebound.localhost:{port}{place_of(live).target('/')}")
    assert page.inner_text("body").startswith("403")
    assert page.evaluate(ATTACK, {**given, "place": f"rebound.localhost:{port}"}) == [
        f"{mode}: {page.text_content('body')}" for mode in ("cors", "no-cors", "same-origin")
    ]
    page.goto(f"http://127.0.0.1:{port}/?websocket=ws://127.0.0.1:{foreign}/&token={place_of(live).token}")
    assert page.inner_text("body").startswith("403")
    page.close()
    assert moved_by(live) == before
    assert live.server.clients == 0
    still_serves(live)


def test_a_viewer_for_other_machines_opens_with_its_token_only(browser):
    viewer = Live(LiveRun(load("fwalk")), host="0.0.0.0", port=0)
    viewer.start()
    place = place_of(viewer)
    nobody = Place(place.port, "")
    for lines in ([f"Host: 127.0.0.1:{place.port}"], [f"Host: machine.example:{place.port}"]):
        assert answer(nobody, *lines).startswith("HTTP/1.1 403")
        assert answer(place, *lines).startswith("HTTP/1.1 200")
    with pytest.raises(InvalidStatus):
        page_socket(nobody)
    with pytest.raises(InvalidStatus):
        page_socket(place, origin="http://evil.example")
    page = browser.new_page(viewport={"width": 400, "height": 400})
    page.goto(viewer.url)
    until(lambda: viewer.server.clients == 1)  # by the cookie
    page.close()
    viewer.stop()


def test_another_user_of_this_machine_who_has_no_token_is_told_what_to_do_and_drives_nothing(live, browser):
    place = place_of(live)
    for wrong in (Place(place.port, ""), Place(place.port, "guess"), Place(place.port, place.token[:-1])):
        said = answer(wrong, f"Host: 127.0.0.1:{place.port}")
        assert said.startswith("HTTP/1.1 403")
        assert "open the whole address that the viewer printed" in said
        with pytest.raises(InvalidStatus, match="403"):
            page_socket(wrong)
    page = browser.new_page()
    page.goto(f"http://127.0.0.1:{place.port}/")
    assert page.inner_text("body").strip() == WITHOUT_TOKEN.strip()
    page.close()


def test_the_address_that_a_browser_is_started_with_is_good_for_one_opening_and_its_page_for_more(live, browser):
    address = live.server.url_once
    assert live.server.guard.access.token not in address
    context = browser.new_context(viewport={"width": 400, "height": 400})
    page = context.new_page()
    nobody_listens(live)
    for opening in (lambda: page.goto(address), page.reload):
        opening()
        page.evaluate("warpmuscle.ready")
        until(lambda: live.server.clients == 1)
    other = browser.new_context().new_page()  # of somebody who read it in the list of processes
    other.goto(address)
    assert other.inner_text("body").strip() == WITHOUT_TOKEN.strip()
    other.context.close()
    context.close()


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
