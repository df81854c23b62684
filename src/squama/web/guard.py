"""Access control of the explorer: only the browser that was given the printed address, on this machine.

A page of another site can send requests from the user's browser to this machine, also under a host name of its own that
resolves to this machine (DNS rebinding). So every request, of a page or of a websocket, must name this machine as its
host, have no other origin, and carry a secret: first that of the address, then another one in a cookie, so that neither
reveals the other. A page loads scripts, styles and pictures from this server only, and connects to no other. Heads of
requests must arrive in time, and connections without the cookie cannot displace those of the owner.
"""

from __future__ import annotations

import asyncio
import hmac
import itertools
import re
import secrets
from typing import TYPE_CHECKING, Any

import h11
from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse
from uvicorn.protocols.http.h11_impl import H11Protocol

if TYPE_CHECKING:
    from starlette.types import ASGIApp, Message, Receive, Scope, Send

TOKEN = "token"
"""Name of the secret in the address."""
HOSTS = re.compile(r"(127\.0\.0\.1|localhost|\[::1\])(:[0-9]{1,5})?", re.IGNORECASE)
"""Names of this machine; with any port, because a tunnel has its own."""
FOREIGN = "The explorer answers for 127.0.0.1, localhost and [::1] only."
OTHER_PAGE = "The explorer answers its own page only."
UNKNOWN = "Open the address that squama explore printed, with its ?token=...: this browser has not been there yet."
KNOWN = "squama.known"
"""Key that the guard sets in the scope of a request with the cookie."""
HEAD = 10.0
"""Seconds within which the head of a request, and the rest of an answered one, must arrive."""
MOST_STRANGERS = 128
"""Largest number of connections without the cookie; the oldest is closed beyond it."""
MOST = 384
"""Largest number of connections."""
_NUMBERS = itertools.count()
_FRESH = {"cache-control": "no-store"}
_SHUT = [
    (b"cross-origin-resource-policy", b"same-origin"),
    (b"referrer-policy", b"no-referrer"),
    (b"x-content-type-options", b"nosniff"),
    (b"x-frame-options", b"DENY"),
]
"""Headers of every answer that close it to other pages."""
POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' ws://{host} wss://{host}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
"""Content security policy of the page. NiceGUI writes scripts into its pages and compiles templates there."""


class Guard:
    """An ASGI application that passes permitted requests on to another one, and answers the rest with 403.

    ``port`` distinguishes the cookies of several explorers on a machine; ``secret``: that of the address; ``pass_``:
    that of the cookie.
    """

    def __init__(self, app: ASGIApp, port: int) -> None:
        self.app = app
        self.secret, self.pass_ = secrets.token_urlsafe(32), secrets.token_urlsafe(32)
        self.cookie = f"squama-{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request."""
        if scope["type"] == "websocket" and self._refusal(scope, self._known(scope)):
            await send({"type": "websocket.close", "code": 1008})
            return
        if scope["type"] in ("lifespan", "websocket"):
            await self.app(scope, receive, send)
            return

        async def shut(message: Message) -> None:
            if message["type"] == "http.response.start":
                kept = (one for one in message["headers"] if not one[0].lower().startswith(b"access-control-"))
                message = {**message, "headers": [*kept, *_SHUT, (b"content-security-policy", policy)]}
            await send(message)

        # another host is refused below
        host = "".join(Headers(scope=scope).getlist("host"))
        policy = POLICY.format(host=host if HOSTS.fullmatch(host) else "localhost").encode()
        start, parts = f"{TOKEN}=".encode(), (scope["query_string"] if scope["path"] == "/" else b"").split(b"&")
        given = b"".join(part[len(start) :] for part in parts if part.startswith(start))
        rest = b"&".join(part for part in parts if not part.startswith(start))
        if known := self._known(scope):
            scope[KNOWN] = True
        if refusal := self._refusal(scope, known or _same(given, self.secret)):
            await PlainTextResponse(f"{refusal}\n", 403, _FRESH)(scope, receive, shut)
        elif given:
            cookie = f"{self.cookie}={self.pass_}; Path=/; HttpOnly; SameSite=Strict"
            place = {"location": "/" + "?" * bool(rest) + rest.decode("latin-1"), "set-cookie": cookie}
            await PlainTextResponse("", 303, _FRESH | place)(scope, receive, shut)
        else:
            await self.app(scope, receive, shut)

    def _known(self, scope: Scope) -> bool:
        """Return whether a request has the cookie."""
        start, cookies = f"{self.cookie}=", Headers(scope=scope).getlist("cookie")
        pairs = (pair.strip() for one in cookies for pair in one.split(";"))
        return any(_same(pair[len(start) :].encode(), self.pass_) for pair in pairs if pair.startswith(start))

    def _refusal(self, scope: Scope, known: bool) -> str:
        """Return why a request is refused; "" for a permitted one."""
        hosts, origins = (Headers(scope=scope).getlist(name) for name in ("host", "origin"))
        if len(hosts) != 1 or not HOSTS.fullmatch(host := hosts[0]):
            return FOREIGN
        own = (f"http://{host}".lower(), f"https://{host}".lower())
        if any(origin.lower() not in own for origin in origins):
            return OTHER_PAGE
        return "" if known else UNKNOWN


def _same(given: bytes, secret: str) -> bool:
    # in constant time, so that the duration does not reveal how much of a guess is right
    return hmac.compare_digest(given, secret.encode())


class Patient(H11Protocol):
    """The HTTP protocol of the :class:`Guard`: time limits for requests, priority for connections with the cookie."""

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.number = next(_NUMBERS)
        self.patience: asyncio.TimerHandle | None = None

    @property
    def known(self) -> bool:
        """Whether the last request had the cookie."""
        return self.scope is not None and KNOWN in self.scope

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for a request; close the oldest connections without the cookie where there are too many."""
        super().connection_made(transport)
        strangers = [one for one in self.connections if isinstance(one, Patient) and not one.known]
        for one in sorted(strangers, key=lambda one: one.number)[:-MOST_STRANGERS]:
            one.transport.abort()
        self._watch()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop the timer."""
        self._rest()
        super().connection_lost(exc)

    def handle_events(self) -> None:
        """Process received data."""
        super().handle_events()
        self._watch()

    def on_response_complete(self) -> None:
        """Wait for the rest of the request, or for the next one."""
        super().on_response_complete()
        self._watch()

    def _watch(self) -> None:
        """Start the timer for a head or the rest of an answered request, unless it runs already."""
        asked, answered = self.conn.their_state, self.conn.our_state
        if asked is not h11.IDLE and (asked is not h11.SEND_BODY or answered is not h11.DONE):
            self._rest()
        elif self.patience is None:
            self.patience = self.loop.call_later(HEAD, self.transport.abort)

    def _rest(self) -> None:
        if self.patience is not None:
            self.patience.cancel()
            self.patience = None
