"""Still pictures and animations of a beam in space, without a browser."""

from __future__ import annotations

import base64
import io
import itertools
import math
import os
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.errors import InputError, Problems, naming, refuse
from squama.io import files
from squama.loads import LOADS, EndsName, JointName, LawName, LoadName, SenseName
from squama.model.outcome import End
from squama.plot.palette import STATES, THEMES, WORDS
from squama.progress import steps
from squama.scene import geometry, standalone
from squama.scene.look import Camera, Canvas, fitted, halves, outline
from squama.scene.motion import ENDED, LOCKED, Motion, Setting, State, shapes
from squama.types import Array

if TYPE_CHECKING:
    from PIL import Image

FORMATS = (".png", ".gif", ".html")
"""File extensions."""
SIZE, SMALL = (1600, 760), (800, 400)
"""Width and height of a picture and of an animation, pixels."""
WORDS_ROOM = 8
"""Share of the height for the text below the beam, as its inverse; the text above has half of it."""
FRAMES = 36
"""Frames of an animation, loading and unloading."""
HEAD, SHAFT, DOT = 0.13, 0.042, 0.07
"""Sizes of arrows and contact points, in pitches."""
FIRST = 0.7
"""Default load, as a share of that of the end."""
Faces = Sequence[tuple[geometry.Design, State]]
"""Design and state of each face with scales."""


class View(NamedTuple):
    """Result of :func:`squama.view`.

    ``files`` that were written; the displayed ``state``; the given load angle per pitch (``asked``) and that of the
    ``last`` state before the ``end`` of the curve, rad; the ``model`` in words, and ``notes`` where it differs from the
    given one or leaves its range. In a notebook it displays a beam that can be turned with the mouse, or a still
    picture where NiceGUI is not installed.
    """

    files: tuple[Path, ...]
    state: State
    asked: float
    last: float
    end: End
    model: str
    notes: tuple[str, ...]
    motion: Motion

    def _repr_html_(self) -> str:
        """Return the page in an isolated frame, which loads nothing from elsewhere."""
        try:
            page = standalone.page(self.motion, self.asked)
        except InputError:
            made = io.BytesIO()
            draw(self.motion, self.asked).save(made, format="PNG")
            return f'<img width="{SMALL[0]}" src="data:image/png;base64,{base64.b64encode(made.getvalue()).decode()}">'
        look = f"width: 100%; height: {SMALL[1] + 150}px; border: 0"
        return f'<iframe sandbox="allow-scripts" style="{look}" srcdoc="{escape(page)}"></iframe>'

    def __repr__(self) -> str:
        return f"View({self.model}: {self.motion.words(self.state)})"


def view(
    beam: Beam,
    *paths: str | os.PathLike[str],
    to: float | str | None = None,
    bend: float | str = 0.0,
    load: LoadName = "twisting",
    mu: float | None = None,
    law: LawName = "edge",
    sense: SenseName = "+",
    margin: float = 0.01,
    joint: JointName | None = None,
    ideal: bool | None = None,
    ends: EndsName | None = None,
    name: str = "",
    dark: bool = False,
    forces: bool = True,
    frames: int = FRAMES,
) -> View:
    """Draw a beam in space under load: pictures, animations of loading and unloading, pages to turn it.

    All scales of the beam are drawn, each with its own motion between the ends (``ends``).

    Parameters
    ----------
    *paths
        Files to write: .png, .gif or .html (needs the extra ``web``); without any only the view is returned.
    to
        Twist or curvature: a rate in rad/m or text such as "5 rad/m", "0.2 rad/pitch", "90 deg total"; default: 0 where
        a bend is held, else 0.7 of that at the end. Beyond the end of the curve the last state is shown.
    bend
        Curvature held while the beam is twisted, in the form of ``to``; positive towards the scaled face. Forces are
        then not drawn.
    load, mu, law, sense, margin, joint, ideal
        "twisting" or "bending", the rest as in :func:`squama.twist`. On the compliant joint each scale has the pose of
        its six motions and is bent by its contacts, and the bar bows; with a held bend scales are drawn flat.
    ends
        As in :func:`squama.twist`. With a held bend, on hinges, or with more than 60 scales, each scale has the motion
        of an endless beam.
    name
        Name of the beam, written above it.
    dark, forces, frames
        Dark background; contact forces; number of frames of an animation, 2 to 500.

    Raises
    ------
    InputError
        An argument is out of range, or a file cannot be written.

    Examples
    --------
    >>> import squama
    >>> shown = squama.view(squama.Beam.from_ratios(mu=0.5), to="0.2 rad/pitch", joint="hinge")
    >>> print(f"{shown.state.name}, theta = {shown.state.theta:.3f}; {shown.end} at {shown.last:.3f} rad per pitch")
    sliding, theta = 0.798; frictional lock at 0.268 rad per pitch
    """
    arguments.beam(beam)
    names = arguments.load(load)
    known(paths)
    count = arguments.whole("frames", frames, 2, 500)
    friction = float(arguments.frictions(beam.friction.mu, mu))
    with naming("bend"):
        curvature = LOADS["bending"].read(bend, pitch=beam.pitch, scales=beam.pitches)
    with naming("to"):
        rate = None if to is None else names.read(to, pitch=beam.pitch, scales=beam.pitches)
    if rate is not None and rate < 0:
        reason = "must be 0 or more" + names.other_way("sense -")
        refuse("to", f"{rate:.6g} rad/m", reason, 'write e.g. "0.2 rad/pitch"')
    far = rate * beam.pitch if rate else math.inf
    motion = Motion(Setting(beam, friction, load, law, margin, sense, joint, ideal, curvature * beam.pitch, ends, far))
    asked = (0.0 if curvature else FIRST * motion.last) if rate is None else rate * beam.pitch
    for path in paths:
        if Path(path).suffix.lower() == ".gif" and not asked:
            reason = "is an animation in which nothing moves: a bend is held and no twist is given"
            refuse(files.label(path), "", reason, "give a twist, or write a .png")
    written = [save(motion, asked, path, name=name, dark=dark, forces=forces, frames=count) for path in paths]
    return viewed(motion, asked, written)


def known(paths: Sequence[str | os.PathLike[str]]) -> None:
    """Refuse files of unknown kinds."""
    problems = Problems()
    for path in paths:
        files.place(path, "beam.png")
        if (ending := Path(path).suffix.lower()) not in FORMATS:
            problems.add("", f'the ending "{ending}"', "is not known", "write .png, .gif or .html", files.label(path))
    problems.settle()


def viewed(motion: Motion, load: float, written: Sequence[Path]) -> View:
    """Return the result of a motion that was drawn at a load angle into files."""
    state, notes = motion.state(load), tuple(motion.notes)
    return View(tuple(written), state, load, motion.last, motion.end, f"{motion.model}; {motion.place}", notes, motion)


def save(
    motion: Motion, load: float, path: str | os.PathLike[str], *, name: str = "", frames: int = FRAMES, **looks: bool
) -> Path:
    """Write a picture (.png), an animation there and back (.gif) or a page (.html) at a load angle (rad per pitch).

    ``name`` of the beam; ``looks``: ``dark`` (False) and ``forces`` (True), as in :func:`squama.view`.
    """
    ending = Path(path).suffix.lower()
    if ending == ".html":
        text = standalone.page(motion, load, name)
        return files.atomic_write(path, lambda place: place.write_text(text, encoding="utf-8"))
    if ending == ".gif":
        # loading and unloading in equal steps of the load, with a fixed camera
        last, there = motion.state(load), max(1, frames // 2)
        states = [*(motion.state(last.load * i / there) for i in range(there)), last]
        pictures = _drawn(motion, states, SMALL, name, **looks)
        pictures += pictures[-2:0:-1]
        more: dict[str, object] = {"save_all": True, "append_images": pictures[1:], "duration": 60, "loop": 0}
    else:
        pictures, more = [draw(motion, load, name, **looks)], {"optimize": True}
    return files.atomic_write(path, lambda place: pictures[0].save(place, format=ending[1:].upper(), **more))


def draw(motion: Motion, load: float, name: str = "", **looks: bool) -> Image.Image:
    """Return the picture of a beam at a load angle (rad per pitch), with its name."""
    return _drawn(motion, [motion.state(load)], SIZE, name, **looks)[0]


def _drawn(
    motion: Motion, states: list[State], size: tuple[int, int], name: str = "", **looks: bool
) -> list[Image.Image]:
    """Return the pictures of states, with one camera that sees every beam and arrow."""
    around = []
    for state, (design, of) in itertools.product(states, shapes(motion)):
        one = of(state)
        around.append(outline(design, one.at, *(each.attitude for each in one.each or [one])))
        if looks.get("forces", True):
            around += [tips for _, tips in _arrows(design, one, motion.setting.mu)[1]]
    wide, high = _stage(size)
    camera = fitted(np.concatenate(around), wide / high)
    return [_framed(motion, state, camera, size, name, **looks) for state in steps(states, len(states), "pictures")]


def _stage(size: tuple[int, int]) -> tuple[int, int]:
    """Return width and height of the beam's part of a picture, without text, pixels."""
    return size[0], size[1] - size[1] // WORDS_ROOM - size[1] // WORDS_ROOM // 2


def render(faces: Faces, mu: float, camera: Camera, size: tuple[int, int], **looks: bool) -> Array:
    """Return the pixels (height, width, 3) of a beam from design and state of each face with scales."""
    theme = {name: _rgb(value) for name, value in THEMES["dark" if looks.get("dark") else "light"].items()}
    canvas = Canvas(*size, camera, theme["background"])
    sections, _ = geometry.bar(faces[0][0], faces[0][1].at)
    a, b, ends = sections[:-1], sections[1:], sections[[0, -1]]
    quads = np.stack([a, b, np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)], axis=2).reshape(-1, 4, 3)
    quads = np.concatenate([quads, ends])
    # one colour for a quadrilateral, because twisted ones are not flat and would show stripes
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    canvas.triangles(halves(quads), np.repeat(_lit(normals, theme["bar"], camera), 2, axis=0))
    for start, stop in ((a, b), (ends, np.roll(ends, -1, axis=1))):
        canvas.lines(start.reshape(-1, 3), stop.reshape(-1, 3), theme["edge"], canvas.size[1] / 1200)
    for design, state in faces:
        for i, k in enumerate(geometry.first(design) + np.arange(design["scales"])):
            own = state.of(i)
            plate = geometry.plate(design, own.bent)
            points = plate.at(geometry.scale(design, state.at, own.attitude, k))
            parts = halves(points[plate.faces])
            normals = np.cross(parts[:, 1] - parts[:, 0], parts[:, 2] - parts[:, 0])
            canvas.triangles(parts, _lit(normals, _rgb(STATES[own.name]), camera))
            start, stop = np.moveaxis(points[plate.edges], 1, 0)
            canvas.lines(start, stop, theme["edge"], size[1] / 600)
    for name, (i, (design, state)) in itertools.product(("normal", "friction"), enumerate(faces)):
        points, arrows = _arrows(design, state, mu)
        if name == "normal":
            canvas.discs(points, DOT, theme["point"], through=True)
        elif i == 0:
            # friction lies within the plates: it is drawn over everything, after the normal forces of all faces
            canvas.near[:] = 0.0
        for tips in [tips for one, tips in arrows if one == name and looks.get("forces", True)]:
            long = np.linalg.norm(tips - points, axis=1, keepdims=True)
            way = np.divide(tips - points, long, out=np.zeros_like(tips), where=long > 0)
            tip = np.minimum(2.6 * HEAD, long / 2)
            neck = points + (long - tip) * way
            # as thick as in the middle of the beam
            thick = canvas.size[1] / 2 * SHAFT / (camera.slope * float(np.median(canvas.place(points)[:, 2])))
            canvas.lines(points, neck, theme[name], max(1.5, thick), through=True)
            aside = np.cross(way, camera.back)
            aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-9)
            wide = np.maximum(tip / 2.6, SHAFT * 1.6) * aside
            canvas.triangles(np.stack([neck - wide, neck + wide, tips], axis=1), theme[name], through=True)
    return canvas.pixels()


def _arrows(design: geometry.Design, state: State, mu: float) -> tuple[Array, list[tuple[str, Array]]]:
    """Return the contact points (n, 3), and the tips of the arrows of each force that there is."""
    points, pairs, sizes = np.empty((0, 3)), [], np.empty((0, 1))
    for i in range(design["scales"] - design["neighbour"]):
        own, beside = state.of(i), state.of(i + design["neighbour"])
        if own.x > 0:
            k, stand = geometry.first(design) + i, geometry.Stand(beside.attitude, beside.bent)
            met = geometry.contact(design, state.at, own.attitude, k, own.bent, stand)
            points = np.vstack([points, met.point])
            pairs.append(geometry.directions(design, state.at, own.attitude, own.slip, k, stand))
            sizes = np.vstack([sizes, geometry.arrow(own.x)])
    arrows = []
    for i, (name, share) in enumerate((("normal", 1.0), ("friction", mu))):
        tips = points + share * sizes * np.array([pair[i] for pair in pairs]).reshape(-1, 3)
        # without slip friction has no direction
        if np.any(tips != points):
            arrows.append((name, tips))
    return points, arrows


def _lit(normal: Array, colour: Array, camera: Camera) -> Array:
    """Return the colours of faces with normals (n, 3), shaded by their angle to the light, equal on both sides."""
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0)
    normal = normal * np.where(normal @ camera.back < 0, -1.0, 1.0)[:, None]
    # in the axes of the camera
    light = np.array([-1.0, 2.0, 2.0]) / 3 @ np.array([camera.right, camera.up, camera.back])
    strength = 0.62 + 0.4 * np.clip(normal @ light, 0, 1)
    return np.asarray(np.clip(strength[:, None] * colour, 0, 1))


def _rgb(text: str) -> Array:
    return np.array([int(text[i : i + 2], 16) for i in (1, 3, 5)]) / 255


def _framed(
    motion: Motion, state: State, camera: Camera, size: tuple[int, int], name: str, **looks: bool
) -> Image.Image:
    """Return the picture with the name of the beam and its model above, and state, legend and scale bar below."""
    import matplotlib as mpl
    from PIL import Image, ImageDraw, ImageFont

    width, height = size
    room, stage = height // WORDS_ROOM, _stage(size)
    faces = [(design, of(state)) for design, of in shapes(motion)]
    beam = render(faces, motion.setting.mu, camera, stage, **looks)
    theme = THEMES["dark" if looks.get("dark") else "light"]
    whole = Image.new("RGB", size, theme["background"])
    whole.paste(Image.fromarray(beam), (0, room // 2))
    pen = ImageDraw.Draw(whole)
    said = motion.words(state)
    title = motion.title(name)
    keys = _keys(motion, faces, theme, **looks)
    box, font = room // 5, Path(mpl.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf")
    letters = ImageFont.truetype(font, room // 3.2)
    legend = sum(3.5 * box + letters.getlength(words) for _, words in keys) - 2 * box
    mark, long = _scale_bar(motion.setting.beam.pitch, camera, stage)
    bar = max(long, letters.getlength(mark)) + 2 * box
    wide = max(letters.getlength(said), letters.getlength(title), legend + bar)
    # as large as the longest line allows
    letters = ImageFont.truetype(font, room // 3.2 * min(1.0, 0.96 * width / wide))
    left, right, x, y = width * 0.02, width * 0.98, width * 0.02, height - room * 0.48
    pen.text((left, height - room * 0.95), said, font=letters, fill=theme["edge"])
    pen.text((left, room * 0.08), title, font=letters, fill=theme["edge"])
    for colour, words in keys:
        pen.rectangle((x, y + box * 0.5, x + box, y + box * 1.5), fill=colour)
        pen.text((x + 1.5 * box, y), words, font=letters, fill=theme["edge"])
        x += 3.5 * box + pen.textlength(words, font=letters)
    thick = max(1, room // 40)
    pen.line((right - long, y, right, y), fill=theme["edge"], width=thick)
    for end in (right - long, right):
        pen.line((end, y - box / 2, end, y + box / 2), fill=theme["edge"], width=thick)
    pen.text((right - long / 2, y + box / 2), mark, font=letters, fill=theme["edge"], anchor="ma")
    return whole


def _keys(motion: Motion, faces: Faces, theme: Mapping[str, str], **looks: bool) -> list[tuple[str, str]]:
    """Return the colours of a picture and what they mean."""
    every = [one for _, state in faces for one in state.each or [state]]
    names = dict.fromkeys(one.name for one in every)
    ends = {name: f" ({motion.end})" if name in (LOCKED, ENDED) else "" for name in names}
    keys = [(STATES[name], f"scales: {WORDS[name]}{ends[name]}") for name in names]
    if looks.get("forces", True) and max(one.x for one in every) > 0:
        keys += [(theme["normal"], "normal force on the tip")]
        keys += [(theme["friction"], "friction on the tip")] if motion.setting.mu else []
    return keys


def _scale_bar(pitch: float, camera: Camera, size: tuple[int, int]) -> tuple[str, float]:
    """Return the text of a scale bar and its length in pixels, valid at the middle of the beam."""
    away = float(camera.eye @ camera.back - camera.middle @ camera.back)
    pixels = size[1] / (2 * camera.slope * away) / pitch
    most = size[0] / 7 / pixels
    step = 10 ** math.floor(math.log10(most))
    long = step * next(n for n in (5, 2, 1) if n * step <= most)
    factor, unit = (1, "m") if long >= 1 else (1e3, "mm")
    return f"{factor * long:g} {unit}", long * pixels
