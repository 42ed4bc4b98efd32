"""Checks before the viewer's server: of each request, and of each message of a page."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable
from http import HTTPStatus
from typing import Any

from warpmuscle.view.access import NO_TOKEN, Access
from warpmuscle.view.messages import LARGEST

CONNECTIONS = 128  # open at once, of any kind
OPENING, CLOSING = 5.0, 1.0  # s that a browser has for it
RATE = 200.0  # messages a second that one page has heard
REFUSED = "403: the viewer answers its own page alone, at the address that it printed.\n"
WITHOUT_TOKEN = "403: this address lacks the viewer's token: open the whole address that the viewer printed.\n"

_log = logging.getLogger("warpmuscle.view")
_silent = logging.Logger("warpmuscle.view.websockets", logging.CRITICAL + 1)  # garbage is not to fill the terminal


class Guard:
    """Checks of one server."""

    def __init__(self, access: Access, protocol: str) -> None:
        """Guard a server; `protocol` is the only WebSocket subprotocol that is taken, that of its own page."""
        self.access, self.protocol = access, protocol
        self._printed: set[str] = set()

    def tell(self, what: str, why: str) -> None:
        """Say once that something was refused; an attacker would fill the terminal."""
        if what not in self._printed:
            self._printed.add(what)
            _log.warning("the viewer refused a %s: %s (said once)", what, why)

    def options(self, answer: Callable[[str], Any]) -> dict[str, Any]:
        """Options of `websockets.asyncio.server.serve`; `answer` gives the response to a path that was not refused."""

        def request_hook(connection: Any, request: Any) -> Any:
            headers = list(request.headers.raw_items())
            why = self.access.refusal(request.path, headers)
            offered = [value for name, value in headers if name.lower() == "sec-websocket-protocol"]
            if why is None and request.headers.get("Upgrade") and offered != [self.protocol]:
                why = "its page is of another version; load it again"
            if why is not None:
                self.tell("request", why)
                said = WITHOUT_TOKEN if why == NO_TOKEN else REFUSED
                return connection.respond(HTTPStatus.FORBIDDEN, said)
            return None if request.headers.get("Upgrade") else answer(request.path)

        def response_hook(connection: Any, request: Any, response: Any) -> None:
            if response.status_code == HTTPStatus.OK:
                response.headers.update(self.access.headers(request.headers["Host"].strip()))

        return {
            "process_request": request_hook, "process_response": response_hook, "max_size": LARGEST, "logger": _silent,
            "create_connection": limited_connection(), "open_timeout": OPENING, "close_timeout": CLOSING,
            "subprotocols": [self.protocol], "compression": None, "server_header": None,
        }  # fmt: skip


def limited_connection() -> Any:
    """The class of connections that are not too many, and of which none says too much."""
    from websockets.asyncio.server import ServerConnection
    from websockets.protocol import State

    opened: dict[Any, None] = {}  # connections in the order in which they came

    class Limited(ServerConnection):
        """A connection that receives no more than so many messages a second."""

        _due = 0.0

        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            super().connection_made(transport)
            opened[self] = None
            if len(opened) > CONNECTIONS:  # the oldest that has asked for nothing yet gives way
                waiting = [each for each in opened if each.state is State.CONNECTING]
                for each in waiting:
                    if not each.transport.is_closing():
                        each.transport.abort()
                        break

        def connection_lost(self, exc: Exception | None) -> None:
            opened.pop(self, None)
            super().connection_lost(exc)

        async def recv(self, decode: bool | None = None) -> Any:
            message = await super().recv(decode)
            now = time.monotonic()
            self._due = max(self._due + 1.0 / RATE, now)
            await asyncio.sleep(self._due - now)
            return message

    return Limited
