"""Viewers: a page that a small server of this machine shows until it is stopped."""

from __future__ import annotations

import threading

from warpmuscle.view.server import PageServer


class Viewer:
    """A page that replays by itself; subclasses drive it by a thread of their own."""

    def __init__(self, server: PageServer) -> None:
        self.server = server
        self._stopped = threading.Event()
        self._failure: BaseException | None = None

    @property
    def url(self) -> str:
        """Where a browser of this machine finds it, with its token."""
        return self.server.url

    def start(self) -> None:
        """Begin to move."""

    def stop(self) -> None:
        """End it all; the address answers no more."""
        self._stopped.set()
        self.server.stop()

    def wait(self) -> None:
        """Return when it has been stopped; raises what went wrong meanwhile."""
        while not self._stopped.wait(0.2):
            pass
        if self._failure is not None:
            raise self._failure


def replay_viewer(page: str, host: str = "127.0.0.1", port: int = 8080, server: PageServer | None = None) -> Viewer:
    """A viewer of a page that needs no more than itself, as `page.replay_html` makes it.

    Args:
        server: that shows another page so far; by default a new one at a host and a port.

    Raises:
        Error: as `PageServer` does.
    """
    if server is None:
        return Viewer(PageServer(host, port, page.encode()))
    server.show(page.encode())
    return Viewer(server)
