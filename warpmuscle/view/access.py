"""Which requests a viewer answers: those of its own page, with its token.

The token keeps out other users of this machine, whose programs reach its ports, too. A page of another origin can reach
the ports of the machine it is shown on. What it cannot do is change what its browser says of it: `Host` is the name in
the address, and stays a foreign one even if that name is made to lead here (DNS rebinding); `Origin` is whose page
asks.
"""

from __future__ import annotations

import ipaddress
import re
import secrets
import socket
from collections.abc import Iterable
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qsl, urlsplit

from warpmuscle.core.errors import Error

LOOPBACK = re.compile(r"(localhost|127\.0\.0\.1|\[::1\])(:[0-9]{1,5})?")
HOST = re.compile(r"([0-9a-z._-]+|\[[0-9a-f:.]+\])(:[0-9]{1,5})?")
QUERY = {"token", "frame", "time", "shot", "view", "plots", "group"}  # what an address may ask for
POLICY = "Content-Security-Policy"
HEADERS = {
    POLICY: "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; connect-src 'self'",
    "X-Frame-Options": "DENY",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}
# The same of pages that are files, which ask for nothing, and where it can say nothing of frames.
POLICY_OF_FILES = "; ".join(
    one for one in HEADERS[POLICY].split("; ") if not one.startswith(("frame-ancestors", "connect-src"))
)
NO_TOKEN = "its address lacks the token"
Headers = Iterable[tuple[str, str]]


def new_token() -> str:
    """Letters that nobody guesses."""
    return secrets.token_urlsafe(16)


@dataclass(frozen=True)
class Access:
    """Who may ask.

    Attributes:
        alone: whether the address has to be a name of this machine that others cannot reach.
        token: what an address has to hold.
        cookie: name under which a browser keeps the token for the page's own requests.
        tickets: are as good as the token in one request; see `ticket`.
    """

    alone: bool = True
    token: str = field(default_factory=new_token)
    cookie: str = field(default_factory=lambda: f"viewer-{secrets.token_hex(4)}")
    tickets: set[str] = field(default_factory=set)

    def ticket(self) -> str:
        """What opens the page once, in place of the token.

        It is for the command line of a browser, which every user of this machine may read.
        """
        self.tickets.add(ticket := new_token())
        return ticket

    def refusal(self, target: str, headers: Headers) -> str | None:
        """Why a request for a target such as `/?token=...` is refused, None if it is not."""
        given = _lists(headers)
        if any(len(given.get(name, [])) > 1 for name in ("host", "origin", "upgrade", "sec-fetch-site")):
            return "it says twice where it comes from"
        host = _one(given, "host").lower()
        if self.alone and not LOOPBACK.fullmatch(host):
            return "its address is no name of this machine alone"
        if not (HOST.fullmatch(host) and self.holds_token(target, headers)):
            return NO_TOKEN
        if unknown := sorted({name for name, _ in _query(target)} - QUERY):
            return f"its address asks for {unknown[0][:20]!a}"
        origin, is_socket = _one(given, "origin").lower(), bool(_one(given, "upgrade"))
        if origin not in (f"http://{host}", f"https://{host}") and (origin or is_socket):
            return "it comes from another page"
        opened = (_one(given, "sec-fetch-mode"), _one(given, "sec-fetch-dest")) == ("navigate", "document")
        if _one(given, "sec-fetch-site") not in ("", "none", "same-origin") and not (opened and not is_socket):
            return "it comes from another page"
        return None

    def holds_token(self, target: str, headers: Headers) -> bool:
        """Whether the address or the cookie of a request holds the token, or the address a ticket, which is used up."""
        cookies: SimpleCookie = SimpleCookie()
        try:
            cookies.load("; ".join(_lists(headers).get("cookie", [])))
        except CookieError:
            return False
        kept = [cookies[self.cookie].value] if self.cookie in cookies else []
        asked = [value for name, value in _query(target) if name == "token"]
        if any(_same(value, self.token) for value in asked + kept):
            return True
        used = {ticket for ticket in self.tickets if any(_same(value, ticket) for value in asked)}
        self.tickets.difference_update(used)
        return bool(used)

    def headers(self, host: str) -> dict[str, str]:
        """What an answer under a host that was not refused tells the browser.

        It is to keep the token, to give the page to no other one, and to connect it with nothing but its server.
        """
        kept = {"Set-Cookie": f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"}
        sockets = f"{HEADERS[POLICY]} ws://{host} wss://{host}"  # which 'self' does not mean in every browser
        return HEADERS | {POLICY: sockets} | kept


def access_to(host: str) -> Access:
    """Access to a server that listens at a host, under any name if other machines can reach it.

    Raises:
        Error: nothing can listen there.
    """
    try:
        found = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)
        for family, kind, protocol, _, address in found:
            with socket.socket(family, kind, protocol) as tried:
                tried.bind(address)
    except (OSError, UnicodeError) as error:
        raise Error(f"the viewer cannot listen at {host}: {getattr(error, 'strerror', None) or error}") from None
    alone = all(ipaddress.ip_address(str(address[0]).partition("%")[0]).is_loopback for *_, address in found)
    return Access(alone)


def _same(offered: str, secret: str) -> bool:
    """Whether two texts are the same, found in a time that does not tell how much of them is."""
    return secrets.compare_digest(offered.encode(errors="replace"), secret.encode())


def _lists(headers: Headers) -> dict[str, list[str]]:
    """Values by names in small letters."""
    lists: dict[str, list[str]] = {}
    for name, value in headers:
        lists.setdefault(name.lower(), []).append(value.strip())
    return lists


def _one(lists: dict[str, list[str]], name: str) -> str:
    return next(iter(lists.get(name, [])), "")


def _query(target: str) -> list[tuple[str, str]]:
    try:
        return parse_qsl(urlsplit(target).query, keep_blank_values=True, errors="replace")
    except ValueError:
        return [("?", "")]
