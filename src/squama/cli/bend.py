"""squama bend: from a beam file to its moment-curvature curve."""

from __future__ import annotations

from squama.cli import run
from squama.cli.options import DEFAULTS, Options


def bend(beam: str, /, *, options: Options = DEFAULTS) -> int:
    """Bend a beam towards its scales: moment, locking and friction, from a beam file.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    return run.respond("bending", beam, options)
