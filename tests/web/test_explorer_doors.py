"""The explorer addressed by strangers: other hosts and origins, no secret, links that are no links."""

from __future__ import annotations

import asyncio
import json
import re
import signal
import socket
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from urllib.parse import quote, urlencode

import pytest
import uvicorn
from web_raw import SOCKET, Raw, explorer, resident

from squama.web import guard, state


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


def test_the_cookie_and_the_address_do_not_tell_each_other(stranger: Raw) -> None:
    name, _, value = stranger.enter().headers["set-cookie"].split(";")[0].partition("=")
    secret = stranger.token.partition("=")[2]
    assert len(value) == len(secret)
    assert value != secret
    assert stranger.ask("/", Cookie=f"{name}={secret}").status == 403
    assert stranger.ask(f"/?token={value}", Cookie=None).status == 403
    assert stranger.ask("/").status == 200


def test_a_page_loads_and_talks_to_nothing_else(known: Raw, stranger: Raw) -> None:
    for answer in (known.ask("/"), known.ask("/none"), stranger.ask("/"), known.ask("/", Host="evil.example")):
        (policy,) = (value for name, value in answer.headers.items() if name == "content-security-policy")
        rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
        assert rules["default-src"] == rules["base-uri"] == rules["form-action"] == "'none'"
        assert rules["frame-ancestors"] == "'none'"
        sources = {source for rule in rules.values() for source in rule.split()}
        own = {f"ws://{known.host}", f"wss://{known.host}", "ws://localhost", "wss://localhost"}
        words = {"'none'", "'self'", "'unsafe-inline'", "'unsafe-eval'", "data:", "blob:"}
        assert sources <= own | words


def test_half_open_requests_leave_the_owner_a_place(address: str, known: Raw) -> None:
    owner = known.address.hostname, known.address.port
    cookie, _, _ = known.cookie.partition("=")
    start = f"GET / HTTP/1.1\r\nHost: {known.host}\r\nCookie: {cookie}=wrong"
    lines = []
    try:
        for i in range(400):
            lines.append(socket.create_connection(owner, timeout=30))
            # some have been answered once, without the cookie
            lines[-1].sendall((f"{start}\r\n\r\n" * (i % 3 == 0) + start).encode())
        assert known.ask("/favicon.ico").status == 200
        assert "squama explorer" in known.ask("/").body
        assert known.knock().status == 101
        # the oldest have gone
        for line in lines[:200]:
            with suppress(ConnectionError):
                while line.recv(1 << 16):
                    pass
    finally:
        for line in lines:
            line.close()


@pytest.mark.parametrize(
    "sent", ["", "GET / HTTP/1.1\r\nX: ", "POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 99999\r\n\r\nx"]
)
def test_heads_and_the_rest_of_what_is_answered_time_out(monkeypatch, sent: str) -> None:
    monkeypatch.setattr(guard, "HEAD", 0.2)

    async def app(scope, receive, send) -> None:
        # whose head is there is waited for
        if scope["path"] == "/slow":
            await asyncio.sleep(1)
        await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
        await send({"type": "http.response.body", "body": b"ok"})

    async def ask() -> None:
        config, state = uvicorn.Config(app, timeout_keep_alive=600), uvicorn.server.ServerState()
        config.load()
        server = await asyncio.get_running_loop().create_server(
            lambda: guard.Patient(config=config, server_state=state, app_state={}), "127.0.0.1", 0
        )
        place = server.sockets[0].getsockname()
        reader, writer = await asyncio.open_connection(*place)
        writer.write(sent.encode())

        async def drip() -> None:
            while True:
                writer.write(b"x")
                await asyncio.sleep(0.02)

        dripping = asyncio.create_task(drip()) if sent else None
        said = b""
        with suppress(ConnectionError):
            said = await asyncio.wait_for(reader.read(), 30)
        if dripping:
            dripping.cancel()
        writer.close()
        answers.append(said)
        reader, writer = await asyncio.open_connection(*place)
        writer.write(b"GET /slow HTTP/1.1\r\nHost: a\r\nConnection: close\r\n\r\n")
        answers.append(await asyncio.wait_for(reader.read(), 30))
        writer.close()
        server.close()
        await server.wait_closed()

    answers: list[bytes] = []
    # in a thread of its own: the loop of the browser's tests is running in this one
    with ThreadPoolExecutor(1) as pool:
        pool.submit(lambda: asyncio.run(ask())).result()
    assert [answer.endswith(b"ok") for answer in answers] == [sent.startswith("POST"), True]


def test_what_no_page_sends_is_dropped_in_silence(known: Raw) -> None:
    """The terminal is read as the explorer ends: no traceback may stand there."""
    text = known.look()
    page = {"client_id": known.page}
    messages = [
        ["event"], ["event", {}], ["event", 1], ["event", None, 2, 3], ["none", {}], [], {}, None, 1, "event",
        ["event", page], ["event", {"client_id": [1]}], ["event", {**page, "id": 4, "args": 1}],
        ["ack", {}], ["ack", {**page, "next_message_id": "x"}], ["log", {**page, "level": "x", "message": 1}],
        ["handshake"], ["handshake", page], ["javascript_response", {}], ["javascript_response", page],
    ]  # fmt: skip
    places = [(m.start(), int(m[1])) for m in re.finditer(r'"(\d+)":\{"tag"', text)]
    hostile = ([], ["1"], ["{"], ['{"number":"x","text":1}'], ['{"number":1}'], ["[]"], ['"x"'], ["null"], ["1", "2"],
               ['{"value":[1,"x"],"seriesId":"cells"}'], ['{"value":[-1,1e9],"seriesId":"cells"}'],
               ['{"value":{},"seriesId":[]}'], ['{"name":1,"data":"!!"}'], ['{"name":"x","data":1}'])  # fmt: skip
    # buttons act on any click, and files would be saved
    listeners = re.finditer(r'"listener_id":"([^"]+)","type":"(change|picked|opened|refused|dark|rest)"', text)
    found = [(max(n for at, n in places if at < m.start()), m[1]) for m in listeners]
    found.sort(key=lambda pair: pair[0])
    assert len(found) > 30
    kinds = {text[text.index(listener) :].split('"type":"')[1].split('"')[0]: (i, listener) for i, listener in found}
    assert {"change", "picked", "opened"} <= set(kinds)
    for i, listener in {*kinds.values(), *found[:2], *found[-2:]}:
        messages += [["event", {**page, "id": i, "listener_id": listener, "args": args}] for args in hostile]
    packets = [f"42{json.dumps(message)}" for message in messages]
    for packet in (
        *packets,
        "4",
        "42",
        '42["event"',
        "43[1]",
        '451-["event",{"_placeholder":true,"num":0}]',
        "5x",
        "9",
    ):
        assert known.tell(packet).status in (200, 400)
    assert "squama explorer" in known.ask("/").body


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
        (f"{link}&beam.scales={'9' * 9000}", "The link cannot be used"),
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


@pytest.mark.slow
def test_pages_that_nobody_looks_at_are_let_go(served: tuple[int, str], known: Raw) -> None:
    link = state.query(state.preset("main"))
    for _ in range(6):
        known.ask(f"/?{link}")
    before = resident(served[0])
    for _ in range(18):
        known.ask(f"/?{link}")
        known.ask("/none")
    # a page is some 2 MiB
    assert resident(served[0]) - before < 25


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("signum", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_also_while_something_is_computed(signum: int) -> None:
    with explorer() as (server, address):
        guest = Raw(address)
        guest.enter()
        guest.look(state.query(state.preset("main").change("theta0", "36").change("joint", "compliant")))
        server.send_signal(signum)
        assert server.wait(20) in (0, 130, -signum, 128 + signum)
