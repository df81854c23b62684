"""The explorer's connections: heads of requests come in time, and strangers do not take the owner's place."""

from __future__ import annotations

import asyncio
import itertools
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

KNOWN = "squama.known"
"""What the guard writes into the scope of a request that has the cookie."""
HEAD = 10.0
"""Seconds within which the head of a request must be there, and what is left of one that is answered."""
MOST_STRANGERS = 128
"""Connections at most of which none has shown the cookie; of more the oldest one goes."""
MOST = 384
"""Connections at most."""
_NUMBERS = itertools.count()


class Patient(H11Protocol):
    """HTTP for :class:`squama.web.guard.Guard`, patient with its owner and not with others."""

    def __init__(self, *given: Any, **named: Any) -> None:
        super().__init__(*given, **named)
        self.number = next(_NUMBERS)
        self.patience: asyncio.TimerHandle | None = None

    @property
    def known(self) -> bool:
        """Whether the last request showed the cookie."""
        return self.scope is not None and KNOWN in self.scope

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Wait for a request, in the place of the oldest stranger where there are too many."""
        super().connection_made(transport)
        strangers = [one for one in self.connections if isinstance(one, Patient) and not one.known]
        for one in sorted(strangers, key=lambda one: one.number)[:-MOST_STRANGERS]:
            one.transport.abort()
        self._watch()

    def connection_lost(self, exc: Exception | None) -> None:
        """Wait no longer."""
        self._rest()
        super().connection_lost(exc)

    def handle_events(self) -> None:
        """Take what has come in."""
        super().handle_events()
        self._watch()

    def on_response_complete(self) -> None:
        """Wait for what is left of the request, or for the next one."""
        super().on_response_complete()
        self._watch()

    def _watch(self) -> None:
        """Wait so long for a head, or the rest of what is answered already; the time does not begin anew."""
        asked, answered = self.conn.their_state, self.conn.our_state
        if asked is h11.IDLE or (asked is h11.SEND_BODY and answered is h11.DONE):
            if self.patience is None:
                self.patience = self.loop.call_later(HEAD, self.transport.abort)
        else:
            self._rest()

    def _rest(self) -> None:
        if self.patience is not None:
            self.patience.cancel()
            self.patience = None
