"""squama view: a beam in space as a picture, an animation or a page of its own, without a browser window."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from squama.cli import flags, output
from squama.cli.flags import flag, settled, whole

if TYPE_CHECKING:
    from squama.scene.motion import Motion


def view(
    beam: flags.BeamFile,
    /,
    *,
    twist: Annotated[str | None, flag(f"How far: {flags.TWISTS} (0.7 of the way to the end).")] = None,
    out: Annotated[tuple[str, ...], flag("File: .png, .gif or .html; may be repeated.", "--out", "-o")] = (),
    mu: flags.Mu = None,
    margin: flags.Margin = 0.01,
    frames: Annotated[int, flag("Pictures of an animation, there and back (36).", read=whole(2, 500, "36"))] = 36,
    load: flags.Load = "twisting",
    law: flags.Law = "edge",
    sense: flags.Sense = "+",
    joint: flags.Joint = "hinge",
    dark: Annotated[bool, Parameter(help="Draw on a dark ground.")] = False,
    no_forces: Annotated[bool, Parameter(help="Leave the forces out.")] = False,
    base: flags.Base = flags.BASE,
) -> int:
    """Draw a beam in space: picture (.png), animation from rest and back (.gif), page that turns it (.html)."""
    from squama.scene import picture, standalone
    from squama.scene.motion import Motion, Setting

    if not out:
        flags.problems().add("--out", "", "is not given", "write e.g. -o beam.png, beam.gif or beam.html")
    flags.check_places([(path, picture.FORMATS) for path in out], [beam])
    with flags.problems().caught():
        if any(path.lower().endswith(".html") for path in out):
            standalone.find()
    described, asked = base.turned(beam, mu, "--twist", twist, load=load, still=True)
    described = settled(described)
    assert described.friction.mu is not None

    with flags.laid(flags.arguments()):
        motion = Motion(Setting(described, described.friction.mu, load, law, margin, sense, joint))
    angle = 0.7 * motion.last if asked is None else asked * described.pitch
    written = [picture.save(motion, angle, path, dark=dark, forces=not no_forces, frames=frames) for path in out]
    return output.report(base.json, beam, written, lambda: _record(motion, angle), lambda: _shown(motion, angle))


def _record(motion: Motion, angle: float) -> dict[str, object]:
    state = motion.state(angle)
    shown = {key: value for key, value in state._asdict().items() if key not in ("x", "slip", "name", "pose")}
    data = {"load": motion.setting.load, "asked": angle, "state": {**shown, "scales": state.name}}
    return {**data, "end": str(motion.end), "last": motion.last}


def _shown(motion: Motion, angle: float) -> Iterable[str]:
    state = motion.state(angle)
    yield f": {state.load:.4g} rad per pitch, inclination {math.degrees(state.theta):.4g} deg, {state.name}"
    if angle > motion.last:
        yield f"asked for {angle:.4g} rad per pitch, but the curve ends before: {motion.end}; its last state is shown"
