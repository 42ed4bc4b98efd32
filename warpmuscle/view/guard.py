"""Checks before a viser server: of each request, and of each message of a browser.

viser answers any page under any name, believes what it is sent, and has no setting for either. It serves through
`websockets.asyncio.server.serve`, whose own hooks do both here. What this file needs of viser: that it calls that
function with the host that it was given, and that `gui._gui_input_handle_from_uuid` holds its controls. Without the
first no server is made; without the second no control moves.
"""

from __future__ import annotations

import asyncio
import logging
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any

from warpmuscle.view.access import Access
from warpmuscle.view.messages import LARGEST, checked

CONNECTIONS = 128  # open at once, of any kind
OPENING, CLOSING = 5.0, 1.0  # s that a browser has for it
RATE = 200.0  # messages a second that one browser has heard
REFUSED = "403: the viewer answers its own page alone, at the address that it printed.\n"

_making = threading.Lock()  # of one server at a time
_log = logging.getLogger("warpmuscle.view")
_silent = logging.Logger("warpmuscle.view.websockets", logging.CRITICAL + 1)  # garbage is not to fill the terminal


class GuardedHost(str):
    """A host that `guarding` knows again, so that other servers of this process stay as they are."""


class Guard:
    """Checks of one server; `server` is viser's, once it is there."""

    def __init__(self, access: Access) -> None:
        self.access = access
        self.server: Any = None
        self.installed = False
        self._told: set[str] = set()

    def control_of(self, identifier: str) -> Any:
        """viser's handle of a control, None if there is none."""
        return None if self.server is None else self.server.gui._gui_input_handle_from_uuid.get(identifier)

    def tell(self, what: str, why: str) -> None:
        """Say once that something was refused; an attacker would fill the terminal."""
        if what not in self._told:
            self._told.add(what)
            _log.warning("the viewer refused a %s: %s (said once)", what, why)

    def options(self, given: dict[str, Any], protocol: str) -> dict[str, Any]:
        """viser's options of `serve` with the checks before its own."""
        answer = given.get("process_request") or (lambda connection, request: None)

        def request_hook(connection: Any, request: Any) -> Any:
            headers = list(request.headers.raw_items())
            why = self.access.refusal(request.path, headers)
            offered = [value for name, value in headers if name.lower() == "sec-websocket-protocol"]
            if why is None and request.headers.get("Upgrade") and offered != [protocol]:
                why = "its page is of another version; load it again"
            if why is not None:
                self.tell("request", why)
                return connection.respond(HTTPStatus.FORBIDDEN, REFUSED)
            return answer(connection, request)

        def response_hook(connection: Any, request: Any, response: Any) -> None:
            if response.status_code == HTTPStatus.OK:
                response.headers.update(self.access.headers(request.headers["Host"].strip()))

        own = {"process_request": request_hook, "process_response": response_hook, "max_size": LARGEST}
        own |= {"create_connection": self._connection_class(), "logger": _silent}
        return given | own | {"open_timeout": OPENING, "close_timeout": CLOSING}

    def _connection_class(self) -> Any:
        from websockets.asyncio.server import ServerConnection
        from websockets.protocol import State

        guard = self

        class Checked(ServerConnection):
            """A connection that receives only what is sound, and not too much of it."""

            _due = 0.0

            def connection_made(self, transport: asyncio.BaseTransport) -> None:
                super().connection_made(transport)
                if len(self.server.handlers) > CONNECTIONS:  # the oldest that has asked for nothing yet gives way
                    waiting = (each for each in self.server.handlers if each.state is State.CONNECTING)
                    next(each for each in waiting if not each.transport.is_closing()).transport.abort()

            async def recv(self, decode: bool | None = None) -> Any:
                while True:
                    message = checked(await super().recv(decode), guard.control_of)
                    if message is not None:
                        break
                    guard.tell("message", "no control of the viewer sends such a one")
                    await asyncio.sleep(0.0)
                now = time.monotonic()
                self._due = max(self._due + 1.0 / RATE, now)
                await asyncio.sleep(self._due - now)
                return message

        return Checked


@contextmanager
def guarding(guard: Guard, host: GuardedHost, protocol: str) -> Iterator[None]:
    """Have the server that is made meanwhile at this host object guarded.

    Args:
        protocol: the only WebSocket subprotocol that is taken; viser prints a line for each other one.
    """
    from websockets.asyncio import server

    def serve(handler: Any, address: Any = None, port: Any = None, **options: Any) -> Any:
        if address is not host:
            return plain(handler, address, port, **options)
        guard.installed = True
        return plain(handler, str(address), port, **guard.options(options, protocol))

    with _making:
        plain = server.serve
        vars(server)["serve"] = serve
        try:
            yield
        finally:
            vars(server)["serve"] = plain
