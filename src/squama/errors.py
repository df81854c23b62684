"""What can go wrong, in the user's words: one line each, with the remedy at its end."""

from __future__ import annotations


class SquamaError(Exception):
    """Base of every error that squama raises on purpose; its text is complete for the user."""


class InputError(SquamaError, ValueError):
    """Something the user gave is not usable.

    The message has one line per mistake: what, where, which value, what is allowed, what to write instead.
    """


class ValidityWarning(UserWarning):
    """A law or an idealisation is used outside the range it was made for."""
