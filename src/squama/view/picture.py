"""Still pictures and animations of a beam in space, without a browser."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from squama import files
from squama.model.solve import Array
from squama.view import geometry, standalone
from squama.view.look import COLOURS, THEMES, WORDS, Camera, fitted, outline
from squama.view.motion import ENDED, LOCKED, Motion, State, shape
from squama.view.raster import Canvas

if TYPE_CHECKING:
    from PIL import Image

FORMATS = (".png", ".gif", ".html")
"""Endings of the files that can be written."""
SIZE, SMALL = (1600, 760), (800, 400)
"""Width and height of a picture and of an animation, pixels."""
FRAMES = 36
"""Pictures of an animation, there and back."""
PAUSE = 60
"""Milliseconds between two of them."""
HEAD, SHAFT, DOT = 0.13, 0.042, 0.07
"""Sizes of arrows and contact points, in pitches."""
_LIGHT = np.array([-1.0, 2.0, 2.0]) / 3
"""Where the light comes from, in the axes of the camera."""


def save(
    motion: Motion, load: float, path: str | Path, *, dark: bool = False, forces: bool = True, frames: int = FRAMES
) -> Path:
    """Write a picture (.png), an animation (.gif) or a page with the view (.html) of a beam under load.

    Parameters
    ----------
    motion : Motion
        The beam's motion.
    load : float
        Load angle per pitch, rad; an animation goes there and back. Beyond the last state that is shown.
    path : path
        Where to write.
    dark, forces : bool
        On a dark ground; with contact forces.
    frames : int
        Number of pictures of an animation.

    Returns
    -------
    Path
        The file's path, as given.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    ending = Path(path).suffix.lower()
    if ending == ".html":
        text = standalone.page(motion, load)
        return files.atomic_write(path, lambda place: place.write_text(text, encoding="utf-8"))
    if ending == ".gif":
        pictures = animation(motion, load, dark=dark, forces=forces, frames=frames)
        more: dict[str, Any] = {"save_all": True, "append_images": pictures[1:], "duration": PAUSE, "loop": 0}
    else:
        pictures, more = [draw(motion, load, dark=dark, forces=forces)], {"optimize": True}
    return files.atomic_write(path, lambda place: pictures[0].save(place, format=ending[1:].upper(), **more))


def draw(
    motion: Motion, load: float, size: tuple[int, int] = SIZE, *, dark: bool = False, forces: bool = True
) -> Image.Image:
    """Return the picture of a beam under load."""
    design = shape(motion.setting, motion.path.neighbour)
    state = motion.state(load)
    camera = fitted(outline(design, state.load, state.theta), size[0] / (size[1] - _bottom(size)))
    return _framed(motion, state, camera, size, dark=dark, forces=forces)


def animation(
    motion: Motion, load: float, size: tuple[int, int] = SMALL, *, dark: bool = False, forces: bool = True,
    frames: int = FRAMES,
) -> list[Image.Image]:  # fmt: skip
    """Return the pictures of a beam that is loaded and let back, evenly in load, from one place."""
    design = shape(motion.setting, motion.path.neighbour)
    last = motion.state(load)
    camera = fitted(outline(design, last.load, last.theta), size[0] / (size[1] - _bottom(size)))
    there = max(1, frames // 2)
    ways = [last.load * i / there for i in range(there + 1)]
    done = [_framed(motion, motion.state(way), camera, size, dark=dark, forces=forces) for way in ways]
    return [*done, *done[-2:0:-1]]


def _bottom(size: tuple[int, int]) -> int:
    """Height of the words below the beam."""
    return size[1] // 8


def render(design: geometry.Design, state: State, mu: float, camera: Camera, size: tuple[int, int], *,
           dark: bool = False, forces: bool = True) -> Array:  # fmt: skip
    """Return the pixels (height, width, 3) of a beam in a state."""
    theme = {name: _rgb(value) for name, value in THEMES["dark" if dark else "light"].items()}
    canvas = Canvas(*size, camera, theme["background"])
    sections, _ = geometry.bar(design, state.load)
    _bar(canvas, sections, theme)
    plates = np.array([geometry.scale(design, state.load, state.theta, geometry.first(design) + i).corners
                       for i in range(design["scales"])])  # fmt: skip
    faces = plates[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    normals = np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0])
    canvas.triangles(faces, _lit(normals, _rgb(COLOURS[state.name]), camera))
    thick = size[1] / 600
    canvas.lines(plates.reshape(-1, 3), np.roll(plates, -1, axis=1).reshape(-1, 3), theme["edge"], thick)
    if state.x > 0:
        _contacts(canvas, design, state, mu, theme, forces=forces)
    return canvas.pixels()


def _bar(canvas: Canvas, sections: Array, theme: dict[str, Array]) -> None:
    a, b = sections[:-1], sections[1:]
    quads = np.stack([a, b, np.roll(b, -1, axis=1), np.roll(a, -1, axis=1)], axis=2).reshape(-1, 4, 3)
    quads = np.concatenate([quads, sections[[0, -1]]])
    faces = quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    # one colour a quadrilateral: twisted ones are not flat, and stripes would show
    normals = np.cross(quads[:, 2] - quads[:, 0], quads[:, 3] - quads[:, 1])
    canvas.triangles(faces, np.repeat(_lit(normals, theme["bar"], canvas.camera), 2, axis=0))
    ends = sections[[0, -1]].reshape(-1, 3)
    thick = canvas.size[1] / 1200
    canvas.lines(a.reshape(-1, 3), b.reshape(-1, 3), theme["edge"], thick)
    canvas.lines(ends, np.roll(sections[[0, -1]], -1, axis=1).reshape(-1, 3), theme["edge"], thick)


def _contacts(
    canvas: Canvas, design: geometry.Design, state: State, mu: float, theme: dict[str, Array], *, forces: bool
) -> None:
    """Draw contact points, and the normal and the friction force on each tip."""
    places = [geometry.first(design) + i for i in range(design["scales"] - design["neighbour"])]
    points = np.array([geometry.contact(design, state.load, state.theta, k).point for k in places]).reshape(-1, 3)
    canvas.discs(points, DOT, theme["point"], through=True)
    ways = [geometry.directions(design, state.load, state.theta, state.slip, k) for k in places]
    for name, i, share in (("normal", 0, 1.0), ("friction", 1, mu)):
        long = geometry.arrow(state.x) * share
        if not (forces and long > 0 and places):
            continue
        way = np.array([pair[i] for pair in ways])
        tip = min(2.6 * HEAD, long)
        neck = points + (long - tip) * way
        # as thick as in the middle of the beam
        thick = canvas.size[1] / 2 * SHAFT / (canvas.camera.slope * float(np.median(canvas.place(points)[:, 2])))
        canvas.lines(points, neck, theme[name], max(1.5, thick), through=True)
        aside = np.cross(way, canvas.camera.back)
        aside /= np.maximum(np.linalg.norm(aside, axis=1, keepdims=True), 1e-9)
        wide = HEAD * min(1.0, tip / HEAD) * aside
        heads = np.stack([neck - wide, neck + wide, points + long * way], axis=1)
        canvas.triangles(heads, np.broadcast_to(theme[name], (len(heads), 3)), through=True)


def _lit(normal: Array, colour: Array, camera: Camera) -> Array:
    """Return the colour of faces with these normals (n, 3) by their angle to the light, on whichever side."""
    size = np.linalg.norm(normal, axis=1, keepdims=True)
    normal = np.divide(normal, size, out=np.zeros_like(normal), where=size > 0)
    normal = normal * np.where(normal @ camera.back < 0, -1.0, 1.0)[:, None]
    light = _LIGHT @ np.array([camera.right, camera.up, camera.back])
    strength = 0.62 + 0.4 * np.clip(normal @ light, 0, 1)
    return np.asarray(np.clip(strength[:, None] * colour, 0, 1))


def _rgb(text: str) -> Array:
    return np.array([int(text[i : i + 2], 16) for i in (1, 3, 5)]) / 255


def _framed(
    motion: Motion, state: State, camera: Camera, size: tuple[int, int], *, dark: bool, forces: bool
) -> Image.Image:
    """Return the picture with its words below."""
    from PIL import Image, ImageDraw

    width, height = size
    room = _bottom(size)
    design = shape(motion.setting, motion.path.neighbour)
    beam = render(design, state, motion.setting.mu, camera, (width, height - room), dark=dark, forces=forces)
    theme = THEMES["dark" if dark else "light"]
    whole = Image.new("RGB", size, theme["background"])
    whole.paste(Image.fromarray(beam), (0, 0))
    pen = ImageDraw.Draw(whole)
    letters = _font(room // 3.2)
    pen.text((width * 0.02, height - room * 0.95), _words(motion, state), font=letters, fill=theme["edge"])
    x, y = width * 0.02, height - room * 0.48
    end = f" ({motion.end})" if state.name in (LOCKED, ENDED) else ""
    keys = [(COLOURS[state.name], f"scales: {WORDS[state.name]}{end}")]
    if forces and state.x > 0:
        keys += [(theme["normal"], "normal force on the tip")]
        keys += [(theme["friction"], "friction on the tip")] if motion.setting.mu else []
    for colour, words in keys:
        box = room // 5
        pen.rectangle((x, y + box * 0.5, x + box, y + box * 1.5), fill=colour)
        pen.text((x + 1.5 * box, y), words, font=letters, fill=theme["edge"])
        x += 3.5 * box + pen.textlength(words, font=letters)
    return whole


def _words(motion: Motion, state: State) -> str:
    beam, twisting = motion.setting.beam, motion.twisting
    total = math.degrees(state.load) * beam.scales
    torque = f"{state.torque * 1e3:.4g} N mm" if abs(state.torque) < 0.1 else f"{state.torque:.4g} N m"
    return (
        f"{'Twist' if twisting else 'Bend'} {state.load:.4f} rad per pitch ({total:.0f}° over {beam.scales} scales), "
        f"inclination {math.degrees(state.theta):.1f}°, {'torque' if twisting else 'moment'} {torque}, "
        f"µ = {motion.setting.mu:g}"
    )


def _font(size: float) -> Any:
    import matplotlib as mpl
    from PIL import ImageFont

    return ImageFont.truetype(str(Path(mpl.get_data_path(), "fonts", "ttf", "DejaVuSans.ttf")), int(size))
