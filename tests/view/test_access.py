"""Which requests a viewer answers, by what a browser says of them."""

from pathlib import Path

import pytest

import warpmuscle
from warpmuscle.core.errors import Error
from warpmuscle.view.access import POLICY, POLICY_OF_FILES, Access, access_to

SOCKET = [("Upgrade", "websocket"), ("Connection", "Upgrade")]


def request(host: str, origin: str | None = None, *, socket: bool = False, **more: str) -> list[tuple[str, str]]:
    headers = [("Host", host), *(SOCKET if socket else [])]
    headers += [("Origin", origin)] if origin is not None else []
    return headers + [(name.replace("_", "-"), value) for name, value in more.items()]


def asked(access: Access, target: str = "/") -> str:
    """A target with the token."""
    return f"{target}{'&' if '?' in target else '?'}token={access.token}"


@pytest.mark.parametrize("host", ["localhost:8080", "127.0.0.1:8080", "[::1]:8080", "localhost", "LocalHost:9000"])
def test_a_page_under_a_name_of_this_machine_alone_is_answered(host):
    access = Access()
    assert access.refusal(asked(access), request(host)) is None
    assert access.refusal(asked(access, "/?frame=3&shot=1"), request(host, sec_fetch_site="none")) is None
    assert access.refusal(asked(access), request(host, f"http://{host.lower()}", socket=True)) is None


@pytest.mark.parametrize(
    "host",
    ["evil.example:8080", "127.0.0.1.evil.example", "localhost.evil.example", "localhost.", "127.0.0.2", "0.0.0.0",
     "evil.example@localhost", "localhost:8080:1", "localhost:", "::1", "[::1", "192.168.0.7:8080", "", "localhost/x",
     "localhost\n", "\u217cocalhost"],
)  # fmt: skip
def test_another_name_is_refused_even_if_it_leads_here(host):
    reason, access = "its address is no name of this machine alone", Access()
    if host != "localhost\n":  # a header ends there
        assert access.refusal(asked(access), request(host)) == reason
        assert access.refusal(asked(access), request(host, f"http://{host}", socket=True)) == reason
    assert access.refusal(asked(access), []) == reason


@pytest.mark.parametrize(
    "origin",
    ["http://evil.example", "http://localhost:9000", "http://127.0.0.1:8080", "null", "", "http://localhost",
     "http://localhost:8080.evil.example", "http://localhost:8080/", "file://", "chrome-extension://abc", None],
)  # fmt: skip
def test_a_socket_is_opened_for_a_page_of_the_same_origin_only(origin):
    access = Access()
    headers = request("localhost:8080", origin, socket=True)
    assert access.refusal(asked(access), headers) == "it comes from another page"


def test_what_another_page_fetches_embeds_or_loads_is_refused_but_not_a_link_to_the_page():
    access, host = Access(), "localhost:8080"
    assert access.refusal(asked(access), request(host, "http://localhost:9000")) == "it comes from another page"
    for site in ("cross-site", "same-site", "odd"):
        for mode, kind in (("no-cors", "script"), ("navigate", "iframe"), ("cors", "empty"), ("", "")):
            headers = request(host, sec_fetch_site=site, sec_fetch_mode=mode, sec_fetch_dest=kind)
            assert access.refusal(asked(access), headers) == "it comes from another page"
        link = {"sec_fetch_site": site, "sec_fetch_mode": "navigate", "sec_fetch_dest": "document"}
        assert access.refusal(asked(access), request(host, **link)) is None
        assert (
            access.refusal(asked(access), request(host, f"http://{host}", socket=True, **link))
            == "it comes from another page"
        )


def test_headers_that_stand_twice_are_refused():
    for name, value in (("host", "localhost"), ("Origin", "http://localhost"), ("UPGRADE", "websocket")):
        headers = [*request("localhost", "http://localhost", socket=True), (name, value)]
        assert Access().refusal("/", headers) == "it says twice where it comes from"


@pytest.mark.parametrize(
    "target",
    ["/?websocket=ws://evil.example", "/?%77ebsocket=ws://evil.example", "/?frame=1&playbackPath=//evil.example/x",
     "/?websocket", "/x?a=b?websocket=1", "//[?websocket=1", "/?\x1b[2J=1"],
)  # fmt: skip
def test_addresses_that_would_lead_the_page_to_another_server_are_refused(target):
    access = Access()
    reason = access.refusal(target, request("localhost", Cookie=f"{access.cookie}={access.token}"))
    assert reason is not None
    assert reason.startswith("its address asks for '")
    assert reason.isprintable()


def test_a_server_that_others_reach_wants_its_token_whatever_the_name():
    access = access_to("0.0.0.0")
    assert len(access.token) >= 20
    assert access.token != access_to("0.0.0.0").token
    cookie, good = access.headers("localhost")["Set-Cookie"].split("; ", 1)
    assert good == "Path=/; HttpOnly; SameSite=Strict"
    for host in ("localhost:8080", "127.0.0.1", "machine.example:8080"):
        own = f"http://{host}"
        assert access.refusal(f"/?token={access.token}", request(host)) is None
        assert access.refusal("/", request(host, own, socket=True, Cookie=f"a=b; {cookie}")) is None
        assert access.refusal("/", request(host, "http://evil.example", socket=True, Cookie=cookie)) is not None
        for wrong in ("/", "/?token=", "/?token=x", f"/?token={access.token[:-1]}", "/?token=\ud800", "/?token=%ff"):
            assert access.refusal(wrong, request(host)) == "its address lacks the token"
        for jar in ("", "token", f"{access.cookie}=", f"{access.cookie}=x", f"other={access.token}", ";;=\x00"):
            assert access.refusal("/", request(host, Cookie=jar)) == "its address lacks the token"
    for host in ("", "a;b", "a b", "a\x1b", "a, b", "[x]", "evil.example'"):
        assert access.refusal(f"/?token={access.token}", request(host)) == "its address lacks the token"
    assert access.refusal(f"/?token={access.token}", []) == "its address lacks the token"


def test_a_server_of_this_machine_alone_wants_its_token_under_its_own_names():
    for host in ("127.0.0.1", "localhost", "::1"):
        try:
            access = access_to(host)
        except Error:
            assert host == "::1"  # a machine without IPv6
            continue
        assert access.alone
        assert len(access.token) >= 20
        assert access.refusal("/", request("localhost:8080")) == "its address lacks the token"
        assert access.refusal(asked(access), request("localhost:8080")) is None
        assert access.refusal(asked(access), request("machine.example:8080")) is not None


def test_a_ticket_opens_one_page():
    access = Access()
    first, second = access.ticket(), access.ticket()
    assert len({first, second, access.token}) == 3
    assert access.refusal(f"/?token={first}", request("evil.example")) is not None
    for ticket in (second, first):
        assert access.refusal(f"/?token={ticket}", request("localhost")) is None
        assert access.refusal(f"/?token={ticket}", request("localhost")) == "its address lacks the token"
        headers = request("localhost", Cookie=f"{access.cookie}={ticket}")
        assert access.refusal("/", headers) == "its address lacks the token"


def test_nothing_else_can_be_embedded():
    headers = Access().headers("localhost:8080")
    assert headers["X-Frame-Options"] == "DENY"
    policy = headers["Content-Security-Policy"].split("; ")
    assert "frame-ancestors 'none'" in policy
    assert policy[-1] == "connect-src 'self' ws://localhost:8080 wss://localhost:8080"


@pytest.mark.parametrize("host", ["203.0.113.1", "no.such.host.invalid", "a" * 300, "x..y", "\x00"])
def test_hosts_where_nothing_can_listen_are_one_clear_error(host):
    with pytest.raises(Error, match="the viewer cannot listen at") as caught:
        access_to(host)
    assert "\n" not in str(caught.value)


def test_pages_that_are_files_have_the_policy_of_the_server_too():
    folder = Path(warpmuscle.__file__).parent
    pages = sorted((folder / "report" / "templates").glob("*.html"))
    assert len(pages) == 6
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert f'<meta http-equiv="{POLICY}" content="{POLICY_OF_FILES}">' in text, page.name
        assert text.index(POLICY) < text.index("<style"), page.name
    assert "default-src 'none'" in POLICY_OF_FILES
    assert "connect-src" not in POLICY_OF_FILES  # so that the default holds
