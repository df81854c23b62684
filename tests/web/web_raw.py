"""What anybody can send to the explorer: bytes to its port, without a browser in between."""

from __future__ import annotations

import base64
import os
import re
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit

ROOT = Path(__file__).parents[2]
SOCKET = "/_nicegui_ws/socket.io/?EIO=4&transport="
UPGRADE = {"Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}


@contextmanager
def explorer(*flags: str) -> Iterator[tuple[subprocess.Popen, str]]:
    """Run the command without a browser; its process, and the address that it prints."""
    command = [sys.executable, "-m", "squama", "explore", *flags, "--no-browser"]
    # NiceGUI would take itself for one of its own tests
    plain = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "NICEGUI"))}
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT, env=plain
    ) as server:
        try:
            assert server.stdout is not None
            found, before = None, ""
            while not found and (line := server.stdout.readline()):
                found, before = re.search(r"http://127\.0\.0\.1:\d+/\?token=[\w-]{43}(?= )", line), before + line
            assert found, before
            yield server, found[0]
            server.terminate()
            said, _ = server.communicate(timeout=60)
        finally:
            server.kill()
    assert "Traceback" not in said, said


class Answer(NamedTuple):
    """Status (0: hung up without one), headers (names in small letters) and body of an answer."""

    status: int
    headers: dict[str, str]
    body: str


class Raw:
    """A stranger at the port of an address; with ``cookie`` no stranger any more."""

    def __init__(self, address: str) -> None:
        self.address = urlsplit(address)
        self.host = self.address.netloc
        self.token = self.address.query
        self.cookie = self.page = self.sid = ""

    def send(self, request: bytes, seconds: float = 30.0) -> bytes:
        """Send bytes and return all that is answered until the other side closes."""
        parts = []
        # a server that has read enough closes with the rest unread
        with (
            socket.create_connection((self.address.hostname, self.address.port), timeout=seconds) as line,
            suppress(ConnectionError),
        ):
            line.sendall(request)
            while part := line.recv(1 << 16):
                parts.append(part)
                if b"101 Switching Protocols" in parts[0]:
                    break
        return b"".join(parts)

    def ask(self, target: str = "/", *, body: str = "", **headers: str | None) -> Answer:
        """Send a request, with headers as given (None: without it), and return the answer."""
        given = {"Host": self.host, "Connection": "close", "Cookie": self.cookie or None} | headers
        if body:
            given |= {"Content-Length": str(len(body)), "Content-Type": "text/plain"}
        lines = [f"{name}: {value}" for name, value in given.items() if value is not None]
        first = f"{'POST' if body else 'GET'} {target} HTTP/1.1"
        text = self.send("\r\n".join([first, *lines, "", body]).encode())
        head, _, body = text.decode("utf-8", "replace").partition("\r\n\r\n")
        first, *rest = head.split("\r\n")
        pairs = (line.partition(": ") for line in rest)
        return Answer(int(first.split()[1]) if first else 0, {name.lower(): value for name, _, value in pairs}, body)

    def knock(self, **headers: str | None) -> Answer:
        """Ask for a websocket."""
        key = base64.b64encode(os.urandom(16)).decode()
        return self.ask(f"{SOCKET}websocket", **{**UPGRADE, "Sec-WebSocket-Key": key, **headers})

    def enter(self) -> Answer:
        """Show the secret of the address, and keep the cookie."""
        answer = self.ask(f"/?{self.token}")
        self.cookie = answer.headers["set-cookie"].split(";")[0]
        return answer

    def look(self, query: str = "") -> str:
        """Open a page as a browser does, with a websocket's stand-in; return its text."""
        text = self.ask(f"/?{query}").body
        page = re.search(r"client_id'?\"?: ?'?\"?([0-9a-f-]{36})", text)
        assert page, text[:2000]
        told = f"&client_id={page[1]}&next_message_id=0&implicit_handshake=true&tab_id=t&document_id=d"
        sid = re.search(r'"sid":"([^"]+)"', self.ask(f"{SOCKET}polling{told}").body)
        assert sid
        self.page, self.sid = page[1], sid[1]
        self.tell("40")
        # the page has a socket as the handshake is answered
        self.ask(f"{SOCKET}polling&sid={self.sid}")
        return text

    def tell(self, packet: str) -> Answer:
        """Send a packet of engine.io in the name of the page that was opened last."""
        return self.ask(f"{SOCKET}polling&sid={self.sid}", body=packet)


def resident(process: int) -> int:
    """Return the memory that a process holds, MiB; 0 where the system does not tell."""
    told = Path(f"/proc/{process}/status")
    found = re.search(r"VmRSS:\s+(\d+)", told.read_text()) if told.exists() else None
    return int(found[1]) // 1024 if found else 0
