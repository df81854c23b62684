"""Damaged links and requests, thrown at a running explorer: each is answered in time and none with an error of its own.

A trial is one server. Requests that are links bear the cookie, and are damaged where a link can be: values, names,
numbers, repetitions, bytes. The rest are strangers': other hosts, origins, cookies, methods, half requests, bytes.
At the end the server must still answer, and hold no more memory than a page or two need.
"""

from __future__ import annotations

import random
import re
import sys
from pathlib import Path
from urllib.parse import quote

sys.path.insert(0, str(Path(__file__).parents[1] / "web"))

from web_raw import SOCKET, Raw, explorer, resident

from squama.web import state

TRIALS = 3
SIZE = 100
SECONDS = 20.0
"""Within which a link is answered; its reading is given up after 5."""
PATIENCE = 1.0
"""Seconds for which a stranger waits, who may have sent half a request."""
GROWTH = 200
"""MiB by which the server may grow."""
START = state.query(state.preset("main"))
VALUES = (
    "", "nan", "inf", "-1", "0", "1e308 m", "1e-320 m", "9" * 400, "9**9**9 m", "1+9**9**9+m", "((((((((1))))))))m",
    "m**m**m", "1 m m m m", "/etc/passwd", "../x.csv", "\n", "a,b\n1,2\n", "\0", "<script>alert(1)</script>", "{0}",
    "%00", "%ff%fe", "\u0661\u0662", "\u0661\u0662 mm", "\u00bd mm",
    "1e9999 mm", "5 furlong/fortnight", "x" * 3000, "true", "[1]", "--1 mm",
    "999999", "1000000", "2", "compliant", "bending", "plate", "-", "1e-9 m", "1e6 m", "89.99999 deg", "1e-12 deg",
)  # fmt: skip
HEADERS = ("Host", "Origin", "Cookie", "Content-Length", "Transfer-Encoding", "Upgrade", "Range", "Accept-Encoding",
           "X-Forwarded-Prefix", "X-Forwarded-Host", "Expect", "Referer", "Accept", "X" * 2000)  # fmt: skip
TARGETS = ("/", "/x", "//evil.example", "/?token=", "/../../etc/passwd", "*", "http://evil.example/", "/_nicegui/",
           f"{SOCKET}polling", f"{SOCKET}websocket", f"{SOCKET}polling&sid=x", "/%00", "/\\",
           "/?" + "&" * 5000)  # fmt: skip


def damaged(draw: random.Random) -> str:
    """Return a link with one to three damages."""
    pairs = START.split("&")
    for _ in range(draw.randint(1, 3)):
        i = draw.randrange(len(pairs))
        name, _, value = pairs[i].partition("=")
        kind = draw.randrange(6)
        if kind < 3:
            pairs[i] = f"{name}={quote(draw.choice(VALUES), errors='replace')}"
        elif kind == 3:
            pairs[i] = f"{draw.choice(['keep', 'joint.matrix', name + '.', name[1:], '__class__'])}={quote(value)}"
        elif kind == 4:
            pairs += [pairs[i]] * draw.choice([1, 3, 100])
        else:
            text = bytearray(pairs[i], "utf-8") or bytearray(b"=")
            text[draw.randrange(len(text))] = draw.choice(b"%&=+;?#~!0")
            pairs[i] = text.decode()
    if draw.random() < 0.2:
        pairs.append("keep=" + quote("&".join(pairs)))
    return "&".join(pairs)


def strange(draw: random.Random, host: str, cookie: str) -> bytes:
    """Return the bytes of a request that no browser of the explorer sends."""
    if draw.random() < 0.15:
        return draw.randbytes(draw.choice([1, 50, 5000])) + b"\r\n\r\n"
    lines = [f"{draw.choice(['GET', 'POST', 'HEAD', 'OPTIONS', 'TRACE', 'X'])} {draw.choice(TARGETS)} HTTP/1.1"]
    lines += [f"Host: {draw.choice([host, host, 'evil.example', 'localhost'])}", "Connection: close"]
    if draw.random() < 0.5:
        lines.append(f"Cookie: {cookie}")
    for name in draw.sample(HEADERS, draw.randint(0, 3)):
        lines.append(f"{name}: {quote(draw.choice(VALUES), safe=' ')}")
    text = "\r\n".join([*lines, "", ""]).encode("latin-1", "replace")
    return text[: draw.randrange(len(text))] + b"\r\n\r\n" if draw.random() < 0.1 else text


def throw(seed: int) -> list[str]:
    """Throw requests at a server; return what was answered wrongly, or not."""
    draw = random.Random(seed)
    failed = []
    with explorer() as (server, address):
        guest = Raw(address)
        guest.enter()
        guest.look(START)
        before = resident(server.pid)
        for case in range(SIZE):
            if draw.random() < 0.6:
                request = f"GET /?{damaged(draw)} HTTP/1.1\r\nHost: {guest.host}\r\nCookie: {guest.cookie}\r\n"
                what = (request + "Connection: close\r\n\r\n").encode("latin-1", "replace")
                seconds, wanted = SECONDS, rb"HTTP/1.1 (200|400)"
            else:
                what = strange(draw, guest.host, guest.cookie)
                seconds, wanted = PATIENCE, rb"HTTP/1.[01] [1-4]\d\d|$|nothing"
            try:
                answer = guest.send(what, seconds)
            except TimeoutError:
                answer = b"nothing"
            if not re.match(wanted, answer):
                failed.append(f"seed {seed}, case {case}: {what[:300]!r}: {answer[:80]!r}")
        last = guest.ask(f"/?{START}")
        if last.status != 200 or server.poll() is not None:
            failed.append(f"seed {seed}: at the end {last.status}, {server.poll()}")
        if (grown := resident(server.pid) - before) > GROWTH:
            failed.append(f"seed {seed}: grew by {grown} MiB")
    return failed


def trial(seed: int) -> list[str]:
    """Do so; what the server complained of is a failure, too."""
    try:
        return throw(seed)
    except (AssertionError, OSError) as error:
        return [f"seed {seed}: {error!r}"[:2000]]
