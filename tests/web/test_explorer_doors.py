"""The explorer addressed by strangers: other hosts and origins, no secret, links that are no links."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from urllib.parse import quote, urlencode

import pytest
from web_raw import SOCKET, Raw, explorer, resident

from squama.web import state


@pytest.fixture(scope="module")
def served() -> Iterator[tuple[int, str]]:
    """Process and address of an explorer."""
    with explorer() as (server, found):
        yield server.pid, found


@pytest.fixture
def address(served: tuple[int, str]) -> str:
    return served[1]


@pytest.fixture
def stranger(address: str) -> Raw:
    return Raw(address)


@pytest.fixture
def known(address: str) -> Raw:
    found = Raw(address)
    found.enter()
    return found


def test_the_secret_is_exchanged_for_a_cookie_and_leaves_the_address(stranger: Raw) -> None:
    link = state.query(state.preset("main"))
    first, _, rest = link.partition("&")
    answer = stranger.ask(f"/?{first}&{stranger.token}&{rest}")
    assert (answer.status, answer.headers["location"]) == (303, f"/?{link}")
    pair, *flags = answer.headers["set-cookie"].split("; ")
    assert {"HttpOnly", "SameSite=Strict", "Path=/"} == set(flags)
    page = stranger.ask(f"/?{link}", Cookie=f"other=1; {pair}")
    assert page.status == 200
    assert "frictional lock" in page.body
    assert stranger.ask(f"/?{stranger.token}").headers["location"] == "/"


def test_without_the_secret_nothing_is_answered(stranger: Raw) -> None:
    name = Raw(f"http://{stranger.host}/?{stranger.token}").enter().headers["set-cookie"].partition("=")[0]
    wrong = stranger.token[:-1] + ("A" if stranger.token[-1] != "A" else "B")
    for target, cookie in (
        ("/", None),
        ("/favicon.ico", None),
        (f"{SOCKET}polling", None),
        (f"/?{wrong}", None),
        ("/?token=", None),
        (f"/favicon.ico?{stranger.token}", None),
        ("/", f"{name}="),
        ("/", f"{name}={wrong.partition('=')[2]}"),
        ("/", f"x{name}={stranger.token.partition('=')[2]}"),
    ):
        answer = stranger.ask(target, Cookie=cookie)
        assert answer.status == 403
        assert answer.body == (
            "Open the address that squama explore printed, with its ?token=...: this browser has not been there yet.\n"
        )
        assert "set-cookie" not in answer.headers
    assert stranger.knock().status == 403


@pytest.mark.parametrize(
    "host",
    ["evil.example", "127.0.0.1.evil.example", "localhost.evil.example:80", "127.0.0.2", "0.0.0.0", "", None,
     "localhost:80@evil.example", "[::1]:x", "localhost\r\nHost: evil.example"],
)  # fmt: skip
def test_other_hosts_are_not_answered(known: Raw, host: str | None) -> None:
    for answer in (known.ask(Host=host), known.knock(Host=host), known.ask(f"/?{known.token}", Host=host)):
        assert answer.status in (400, 403)
        assert "squama explorer" not in answer.body
        assert "set-cookie" not in answer.headers
    port = known.address.port
    for own in (f"localhost:{port}", "localhost", "LOCALHOST:8080", "[::1]:9", f"127.0.0.1:{port}"):
        assert known.ask("/favicon.ico", Host=own).status == 200


@pytest.mark.parametrize(
    "origin",
    ["https://evil.example", "null", "http://127.0.0.1", "http://localhost:{port}", "http://127.0.0.1:{port}.evil",
     "file://", "ws://127.0.0.1:{port}", ""],
)  # fmt: skip
def test_pages_of_other_origins_are_not_answered(known: Raw, origin: str) -> None:
    given = origin.format(port=known.address.port)
    for answer in (known.ask(Origin=given), known.ask(f"{SOCKET}polling", Origin=given), known.knock(Origin=given)):
        assert answer.status == 403
        assert not [name for name in answer.headers if name.startswith("access-control")]


def test_the_own_page_is_answered_and_no_other_origin_allowed(known: Raw) -> None:
    for own in (f"http://{known.host}", f"HTTP://{known.host}"):
        assert known.knock(Origin=own).status == 101
    answer = known.ask(f"{SOCKET}polling", Origin=f"http://{known.host}")
    assert answer.status == 200
    assert not [name for name in answer.headers if name.startswith("access-control")]
    assert answer.headers["x-frame-options"] == "DENY"
    # through a tunnel the port is another one
    assert known.knock(Host="localhost:9999", Origin="http://localhost:9999").status == 101


def test_a_link_cannot_keep_the_explorer_busy(known: Raw) -> None:
    link = state.query(state.preset("main"))
    start = time.monotonic()
    for query, words in (
        (urlencode({"scale.length": "1+9**9**9+m"}), "The link cannot be used"),
        (f"{link}&" + "&".join(["keep=" + quote("scale.length=1**9**9**9 m")] * 3), "The link cannot be used"),
        ("&".join(["mu=1"] * 500), "more than 64 values"),
        ("a" * 30_000, "longer than 20000 characters"),
        (link.replace("scales=25", "scales=" + "9" * 9000), "The link cannot be used"),
    ):
        answer = known.ask(f"/?{query}")
        assert answer.status == 200
        assert words in answer.body
    assert known.ask(f"/?{link}&{'x' * 500_000}").status in (0, 400)
    assert known.ask("/favicon.ico", X="x" * 500_000).status in (0, 400)
    assert known.ask("/favicon.ico").status == 200
    assert time.monotonic() - start < 60


def test_a_link_names_no_file(known: Raw) -> None:
    link = state.query(state.preset("main"))
    answers = {known.ask(f"/?{link}&joint.matrix={quote(name)}").body.count("names a file")
               for name in ("/etc/passwd", "/etc/none", "pyproject.toml")}  # fmt: skip
    assert answers == {1}


def test_pages_that_nobody_looks_at_are_let_go(served: tuple[int, str], known: Raw) -> None:
    link = state.query(state.preset("main"))
    for _ in range(10):
        known.ask(f"/?{link}")
    before = resident(served[0])
    for _ in range(30):
        known.ask(f"/?{link}")
        known.ask("/none")
    # a page is some 2 MiB
    assert resident(served[0]) - before < 25


@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_also_while_something_is_computed(signum: int) -> None:
    with explorer() as (server, address):
        guest = Raw(address)
        guest.enter()
        guest.look(state.query(state.preset("main").change("theta0", "26").change("joint", "compliant")))
        server.send_signal(signum)
        assert server.wait(20) in (0, 130, -signum, 128 + signum)
