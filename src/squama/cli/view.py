"""squama view: a beam in space as a picture, an animation or a web page, without a browser window."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli import flags, output
from squama.cli.flags import flag, settled, whole
from squama.loads import LOADS
from squama.people import figure, turned

if TYPE_CHECKING:
    from squama.scene.picture import View

_TWIST = f"Twist to draw: {flags.TWISTS}. Default: 0.7 of that at the end; 0 with --bend."
_BEND = f"Bend that is held meanwhile: {flags.TWISTS}; negative is away from the scales."
_OUT = "File to write (.png, .gif, .html); may be repeated."
_FRAMES = "Pictures of an animation, there and back. Default: 36."


def view(
    beam: flags.BeamFile,
    /,
    *,
    twist: Annotated[str | None, flag(_TWIST)] = None,
    bend: Annotated[str | None, flag(_BEND)] = None,
    out: Annotated[tuple[flags.File, ...], flag(_OUT, "--out", "-o")] = (),
    mu: flags.Mu = None,
    margin: flags.Margin = 0.01,
    frames: Annotated[int, flag(_FRAMES, read=whole(2, 500, "36"))] = 36,
    how: flags.How = flags.HOW,
    ends: flags.Ends = None,
    sense: flags.Sense = "+",
    dark: Annotated[bool, Parameter(help="Draw on a dark background.")] = False,
    no_forces: Annotated[bool, Parameter(help="Draw no forces.")] = False,
    base: flags.Base = flags.BASE,
) -> int:
    """Draw a beam in space: picture (.png), animation from rest and back (.gif), page to turn it (.html)."""
    from squama.scene import picture, standalone

    if not out:
        flags.problems().add("--out", "", "is not given", "write e.g. -o beam.png, beam.gif or beam.html")
    flags.check_places([(path, picture.FORMATS) for path in out], [beam])
    with flags.problems().caught():
        if any(path.lower().endswith(".html") for path in out):
            standalone.find()
    given = base.beam(beam, mu)
    rate = flags.asked("--twist", twist, given, how.load, still=True)
    described = settled(given)
    drawn: dict[str, Any] = {"name": Path(beam).stem, "dark": dark, "forces": not no_forces, "frames": frames}
    model: dict[str, Any] = {"margin": margin, "ends": ends, "sense": sense, **vars(how)}
    with flags.laid(flags.arguments("bend", "ends")):
        found = picture.view(described, *out, to=rate, bend=0.0 if bend is None else bend, **drawn, **model)
    return output.report(base.json, beam, found.files, _record(how.load, found), _shown(found))


def _record(load: str, found: View) -> dict[str, object]:
    state, kind = found.state, LOADS[load]
    faces = [{"theta": one.theta, "N": one.N, "f": one.f, "name": one.name} for one in (state, state.other) if one]
    shown: dict[str, object] = {kind.angle: state.load, kind.torque: state.torque, **faces[0]}
    if faces[1:]:
        shown["other"] = faces[1]
    data = {"load": load, "bend": found.motion.setting.bend, "asked": found.asked, "state": shown}
    return {**data, "model": found.model, "warnings": found.notes, "end": str(found.end), "last": found.last}


def _shown(found: View) -> Iterable[str]:
    state, asked = found.state, found.asked
    faces = [f"inclination {figure(math.degrees(one.theta), 'deg')}, {one.name}" for one in (state, state.other) if one]
    beam, bend = found.motion.setting.beam, found.motion.setting.bend
    done = f"{f'bent by {turned(bend, beam)} and ' if bend else ''}{found.motion.kind.done}"
    yield f": {done} by {turned(state.load, beam)}, {'; on the other face '.join(faces)}; {found.model}"
    if asked > found.last:
        yield f"asked for {turned(asked, beam)}, but the curve ends before: {found.end}; its last state is shown"
    yield from output.warnings(found.notes)
