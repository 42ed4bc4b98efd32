"""What pages are sent, in order, whenever they open their socket."""

import threading
from typing import Any

import pytest

pytest.importorskip("websockets", reason="no websockets: pip install 'warpmuscle[view]'")
from live_viewer import PATIENCE, page_socket, place_of, until
from warpmuscle.view.server import PageServer


def test_what_is_said_while_a_page_opens_comes_behind_what_it_is_told_first():
    server = PageServer("127.0.0.1", 0, b"page")
    asked, said = threading.Event(), threading.Event()

    def first() -> list[str]:
        asked.set()
        said.wait(PATIENCE)
        return ["first", "second"]

    server.on_open = first
    with page_socket(place_of(server)) as page:
        assert asked.wait(PATIENCE)
        server.tell(b"a picture, which may be missed")
        server.tell("third")
        said.set()
        heard = [page.recv(timeout=PATIENCE)]
        while heard[-1] != "third":
            heard.append(page.recv(timeout=PATIENCE))
        assert [one for one in heard if isinstance(one, str)] == ["first", "second", "third"]
        until(lambda: server.clients == 1)
        server.tell("fourth")
        assert page.recv(timeout=PATIENCE) == "fourth"
    until(lambda: server.clients == 0)
    server.stop()


def test_what_is_said_at_the_moment_at_which_a_page_is_open_is_not_lost():
    class Begun(dict[Any, list[str]]):
        def __delitem__(self, page: Any) -> None:
            super().__delitem__(page)
            server.tell("at that moment")  # as another thread may

    server = PageServer("127.0.0.1", 0, b"page")
    server._begun = Begun()
    with page_socket(place_of(server)) as page:
        until(lambda: server.clients == 1)
        server.tell("later")
        assert page.recv(timeout=PATIENCE) == "at that moment"
    server.stop()
