"""A small server of one page and its socket, behind a `Guard`, in a thread of its own."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from http import HTTPStatus
from importlib.metadata import version
from typing import Any
from urllib.parse import urlsplit

from warpmuscle.core.errors import Error
from warpmuscle.view.access import access_to
from warpmuscle.view.guard import Guard

NEXT_PORTS = 50  # that are tried where one is taken
BEHIND = 1 << 20  # bytes that wait for a browser, beyond which it misses pictures
PROTOCOL = f"warpmuscle-{version('warpmuscle')}"
Message = str | bytes


def nobody(_: Any) -> None:
    """What hears messages of a page that says nothing."""


class PageServer:
    """Serves a page at `/`, hears what it says, and tells all that show it.

    Attributes:
        on_message: is called with what a page sent, by the server's thread.
        on_open: gives what a page is sent at first.
    """

    def __init__(self, host: str, port: int, page: bytes) -> None:
        """Listen at a port of a host or the next free one, any if 0.

        Raises:
            Error: the library `websockets` is missing, or nothing can listen there.
        """
        try:
            import websockets.asyncio.server  # noqa: F401
        except ImportError:
            raise Error(
                "the viewer needs websockets: pip install 'warpmuscle[view]'; --export writes a page without it"
            ) from None
        self.page = page
        self.guard = Guard(access_to(host), PROTOCOL)
        self.on_message: Callable[[Message], None] = nobody
        self.on_open: Callable[[], Sequence[Message]] = tuple
        self._host = host
        self._clients: set[Any] = set()
        self._begun: dict[Any, list[str]] = {}  # pages that are yet to hear what comes first, and what comes meanwhile
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()
        try:
            self._server = asyncio.run_coroutine_threadsafe(self._listen(port), self._loop).result()
        except Error:
            self._end_loop()
            raise
        self.port = int(self._server.sockets[0].getsockname()[1])

    async def _listen(self, port: int) -> Any:
        from websockets.asyncio.server import serve

        for tried in [port] if port == 0 else range(port, min(port + NEXT_PORTS, 65536)):
            try:
                return await serve(self._serve_socket, self._host, tried, **self.guard.options(self._answer))
            except OSError as error:
                failure = error
        raise Error(f"the viewer cannot listen at {self._host}, port {port} or behind it: {failure.strerror}")

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_forever()

    def _answer(self, target: str) -> Any:
        from websockets.datastructures import Headers
        from websockets.http11 import Response

        found = urlsplit(target).path == "/"
        body = self.page if found else b"404\n"
        status = HTTPStatus.OK if found else HTTPStatus.NOT_FOUND
        kind = "text/html; charset=utf-8" if found else "text/plain"
        headers = Headers({"Content-Type": kind, "Content-Length": str(len(body)), "Connection": "close"})
        return Response(status.value, status.phrase, headers, body)

    async def _serve_socket(self, connection: Any) -> None:
        from websockets.exceptions import ConnectionClosed

        later = self._begun[connection] = []
        try:
            for message in await asyncio.to_thread(self.on_open):
                await connection.send(message)
            while later:
                await connection.send(later.pop(0))
            self._clients.add(connection)  # before it is no longer among those: `tell` looks from other threads
            del self._begun[connection]
            while True:
                message = await connection.recv()
                await asyncio.to_thread(self.on_message, message)
        except ConnectionClosed:
            pass
        finally:
            self._begun.pop(connection, None)
            self._clients.discard(connection)

    @property
    def clients(self) -> int:
        """Number of pages that listen."""
        return len(self._clients)

    @property
    def url(self) -> str:
        """Where a browser of this machine finds it, with the token, without which it answers nobody."""
        return self._address(self.guard.access.token)

    @property
    def url_once(self) -> str:
        """The same for the first who opens it: what a browser is started with can be read by other users."""
        return self._address(self.guard.access.ticket())

    def _address(self, token: str) -> str:
        host = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(self._host, self._host)
        place = f"[{host}]" if ":" in host else host
        return f"http://{place}:{self.port}/?token={token}"

    def tell(self, message: Message) -> None:
        """Tell all pages; those that are far behind miss it if it is binary."""
        if self._clients or self._begun:
            self._loop.call_soon_threadsafe(self._tell, message)

    def _tell(self, message: Message) -> None:
        from websockets.asyncio.server import broadcast

        ready = [one for one in self._clients
                 if isinstance(message, str) or one.transport.get_write_buffer_size() < BEHIND]  # fmt: skip
        broadcast(ready, message)
        if isinstance(message, str):
            for later in self._begun.values():
                later.append(message)

    def show(self, page: bytes, on_open: Callable[[], Sequence[Message]] = lambda: ["{}"]) -> None:
        """Serve another page from now on; those that show the one before are notified, and load it."""
        self.page, self.on_open = page, on_open
        self.tell("{}")

    def stop(self) -> None:
        """End it; the address answers no more."""
        if self._loop.is_closed():
            return
        with suppress(TimeoutError):  # its thread ends with the process anyway
            asyncio.run_coroutine_threadsafe(self._close(), self._loop).result(timeout=10.0)
        self._end_loop()

    def _end_loop(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(timeout=10.0)
        if not self._thread.is_alive():
            self._loop.close()

    async def _close(self) -> None:
        for connection in [*self._server.connections]:
            connection.transport.abort()
        self._server.close()
        await self._server.wait_closed()
        others = [task for task in asyncio.all_tasks() if task is not asyncio.current_task()]
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)
