"""squama twist: from a beam file to its torque-twist curve."""

from __future__ import annotations

from typing import Annotated

from squama.cli import run
from squama.cli.options import DEFAULTS, Options, flag


def twist(
    beam: str,
    /,
    *,
    law: Annotated[str, flag("Force law: edge (satisfies virtual work) or plate (the paper's).")] = "edge",
    sense: Annotated[str, flag("Which way the beam is twisted: + or - (+).")] = "+",
    joint: Annotated[
        str, flag("How a scale is held: hinge (closed form) or compliant (six motions, by finite elements) (hinge).")
    ] = "hinge",
    options: Options = DEFAULTS,
) -> int:
    """Twist a beam: torque, locking and friction, from a beam file.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    return run.respond("twisting", beam, options, law=law, sense=sense, joint=joint)
