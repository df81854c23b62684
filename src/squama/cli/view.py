"""squama view: a beam in space as a picture, an animation or a page of its own, without a browser window."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Problems, check_places, flag, read_number, read_overrides
from squama.errors import InputError

if TYPE_CHECKING:
    from squama.design import Beam
    from squama.view.motion import Motion


def view(
    beam: str,
    /,
    *,
    twist: Annotated[
        str | None,
        flag('How far: "5 rad/m", "0.2 rad/pitch" or "90 deg total" (0.7 of the way to the end).'),
    ] = None,
    out: Annotated[
        tuple[str, ...], Parameter(name=("--out", "-o"), help="File: .png, .gif or .html; may be repeated.")
    ] = (),
    load: Annotated[str, flag("twisting or bending; in bending the twist is a curvature (twisting).")] = "twisting",
    law: Annotated[str, flag("Force law: edge (satisfies virtual work) or plate (the paper's).")] = "edge",
    sense: Annotated[str, flag("Sense of the twist: + or -.")] = "+",
    mu: Annotated[str | None, flag("Coefficient of friction, e.g. 0.25.")] = None,
    margin: Annotated[str, flag("How near to a lock: fraction of the path left before it (0.01).")] = "0.01",
    frames: Annotated[str, flag("Pictures of an animation, there and back (36).")] = "36",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    dark: Annotated[bool, Parameter(help="Draw on a dark ground.")] = False,
    no_forces: Annotated[bool, Parameter(help="Leave the forces out.")] = False,
    json: Annotated[bool, Parameter(help="Print the state as JSON instead of a line.")] = False,
) -> int:  # fmt: skip
    """Draw a beam in space: picture (.png), animation from rest and back (.gif), page that turns it (.html).

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import checks, files
    from squama.cli import run
    from squama.view import picture, three
    from squama.view.motion import Motion, Setting

    problems = Problems()
    overrides: dict[str, dict[str, Any]] = {}
    near, count, described = 0.01, 36, None
    with problems.caught():
        overrides = read_overrides(set_)
    with problems.caught():
        if mu is not None:
            overrides.setdefault("friction", {})["mu"] = read_number("--mu", mu, 0.0, 10.0, "0 to 10", "0.25")
    with problems.caught():
        near = read_number("--margin", margin, 1e-12, 1 - 1e-12, "at least 1e-12, below 1", "0.01")
    with problems.caught():
        count = _frames(frames)
    choices = (("load", load, ("twisting", "bending")), ("law", law, ("edge", "plate")), ("sense", sense, ("+", "-")))
    for name, value, allowed in choices:
        with problems.caught():
            checks.one_of(f"--{name}", value, allowed)
    if not out:
        problems.lines.append("--out: is not given; write e.g. -o beam.png, beam.gif or beam.html")
    problems.lines += check_places([(path, picture.FORMATS) for path in out], [beam])
    with problems.caught():
        if any(path.lower().endswith(".html") for path in out):
            three.find()
    with problems.caught():
        described = run.read_beam(beam, overrides)
    if described is not None and described.friction.mu is None:
        problems.lines.append(
            f"{files.label(beam)}: friction.mu: is missing; write mu = 0.25 under [friction] or give --mu 0.25"
        )
    asked: float | None = None
    with problems.caught():
        if twist is not None and described is not None:
            asked = _asked(twist, load, described)
    problems.settle()
    assert described is not None
    assert described.friction.mu is not None
    motion = Motion(Setting(described, described.friction.mu, load, law, near, sense))
    angle = 0.7 * motion.last if asked is None else asked
    written = [
        picture.save(motion, angle, path, dark=dark, forces=not no_forces, frames=count) for path in out
    ]  # fmt: skip
    _report(files.label(beam), motion, angle, written, json=json)
    return 0


def _frames(text: str) -> int:
    value = read_number("--frames", text, 2, 500, "2 to 500", "36")
    if value != int(value):
        message = f"--frames = {text}: is not a whole number; write e.g. 36"
        raise InputError(message)
    return int(value)


def _asked(text: str, load: str, beam: Beam) -> float:
    """Return the load angle per pitch that is asked for."""
    from squama import units

    read = units.twist if load == "twisting" else units.curvature
    try:
        rate = read(text, pitch=beam.pitch, scales=beam.scales, bare=False)
    except units.QuantityError as error:
        message = f"--twist = {error.shown}: {error.reason}"
        raise InputError(message) from None
    if rate < 0:
        other = "; for the other way round write --sense -" if load == "twisting" else ""
        message = f'--twist = {units.shown(text)}: must be 0 or more{other}; write e.g. "0.2 rad/pitch"'
        raise InputError(message)
    return rate * beam.pitch


def _report(file: str, motion: Motion, angle: float, written: list[Path], *, json: bool) -> None:
    """Say what is shown."""
    from squama.files import label

    state = motion.state(angle)
    if json:
        from squama.cli import record

        shown = {key: value for key, value in state._asdict().items() if key not in ("x", "slip", "name")}
        data = {"file": file, "load": motion.setting.load, "asked": angle, "state": {**shown, "scales": state.name}}
        record.show({**data, "end": str(motion.end), "last": motion.last, "written": [str(path) for path in written]})
        return
    import math

    print(f"{file}: {state.load:.4g} rad per pitch, inclination {math.degrees(state.theta):.4g} deg, {state.name}")
    if angle > motion.last:
        print(f"asked for {angle:.4g} rad per pitch, but the curve ends before: {motion.end}; its last state is shown")
    for path in written:
        print(f"wrote {label(path)}")
