"""The door of parts under load: ``squama.load``."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from squama import arguments
from squama.beam.design import Beam
from squama.contacts import entry, increments, path, row
from squama.contacts.system import EQUAL, PHI, STRAINS
from squama.curves import compliant, doors, labelled, rows
from squama.curves.chosen import COMPLIANT
from squama.curves.labelled import Answer, Labelled
from squama.curves.way import States, Way
from squama.errors import refuse
from squama.loads import LOADS, MANY_SCALES, NOTHING
from squama.model import section
from squama.part import grading, loaded, loading
from squama.part.definition import Part
from squama.part.grading import Grades
from squama.part.loading import Load, Support
from squama.part.told import Told
from squama.units import number

if TYPE_CHECKING:
    import xarray as xr


def load(
    beam: Beam | Part,
    load: str | Sequence[str] | None = None,
    *,
    support: str | None = None,
    scales: int | None = None,
    along: Grades | str | os.PathLike[str] | None = None,
    mu: float | None = None,
    points: int = 50,
    back: bool = False,
    ideal: bool | None = None,
    hold: str | None = None,
) -> xr.Dataset:
    """Load a part: a beam of N scales on its supports, under forces, moments, a tendon or its weight.

    Each cell finds its own bend, twist, lateral bend and stretch; the bar may move far (docs, theory: parts).

    Parameters
    ----------
    beam
        The beam; or a :class:`squama.Part`, e.g. of a file, in which case ``load``, ``support`` and ``along`` take the
        place of its own where they are given.
    load
        What loads it, all of it growing alike from 0: texts such as "0.2 N up at tip", "0.5 N down over all", "weight
        down", "30 N mm twist", "20 N mm bend", "3 N tendon at 4 mm", "1 N thrust at 0 mm", "20 kPa pressure on 10 mm x
        4 mm at -2 mm"; or one deformation that is imposed, "10 mm down at middle", "90 deg twist". Up is towards the
        scaled side, right along the scales' width, out from the root to the tip. Forces keep their direction. Several
        texts are parted by ";" or given as a list.
    support
        "clamped" (if not given): the root is held, the tip is free; "gripped": both ends stay on one axis, and may come
        nearer; "simple" or "simple, span 180 mm": on two rollers, across which the part may slide.
    scales
        Number of scales, 2 to 200; the beam's own if not given.
    along
        Grading: names of the beam's lengths and angles with two values, of the first and the last scale, or one for
        each scale: ``{"scale.theta0": ["5 deg", "10 deg"]}``; or a table (CSV) with a row for each scale, whose columns
        are such names with their units: ``scale.theta0 (deg)``.
    mu
        Coefficient of friction; the beam's own if not given.
    points
        Number of points to all of the load; as many on the way back.
    back
        Take the load off again: friction leaves a part deformed.
    ideal, hold
        As of :func:`squama.twist`; ``hold``: strains that each cell keeps at 0.

    Returns
    -------
    xarray.Dataset
        Dimensions ``point``, ``scale`` (1 to N), ``section`` (0 to N, between cells), ``axis`` and ``direction`` (x, y,
        z). The points have as coordinates the ``share`` of the load and the ``travel`` of its place (``turn`` of a
        torque). Along them are the load ``F`` (``moment``); at the same travel that without contact, ``F_bare``, and
        that of a part whose cells each have the law of an endless beam, ``F_periodic``; ``root_force`` and
        ``root_moment``, energies and frictional work; of sections ``x_axis``, ``y_axis``, ``z_axis`` and their axes
        ``frame``; of scales what :func:`squama.row` tells. ``share_e``, ``end``, ``other_contact`` and
        ``energy_error``. SI units and radians.

    Raises
    ------
    InputError
        An argument is out of range, or the joint of the beam is not known.

    Examples
    --------
    >>> import squama
    >>> beam = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45)
    >>> r = squama.load(beam, "40 deg bend", scales=8, mu=0.2)
    >>> stiffer = float((r.moment / r.moment_bare)[-1])
    >>> print(f"engaged at {float(r.share_e):.2f} of it, {stiffer:.1f} times the bare moment")
    engaged at 0.58 of it, 1.3 times the bare moment
    """
    part = of(beam)
    given: dict[str, Any] = {"load": load, "support": support, "along": along}
    part = replace(part, **{name: value for name, value in given.items() if value is not None})
    how: dict[str, Any] = {"mu": mu, "ideal": ideal, "hold": hold}
    return followed(part, scales=scales, points=points, back=back, endless=True, **how)[0].dataset()


def of(beam: Beam | Part) -> Part:
    """Return a part, or a beam as a part without loads of its own."""
    return beam if isinstance(beam, Part) else Part(beam)


def followed(
    part: Part,
    *,
    scales: int | None = None,
    points: int = 50,
    back: bool = False,
    mu: float | None = None,
    ideal: bool | None = None,
    hold: str | None = None,
    endless: bool = False,
) -> tuple[Answer, Told]:
    """Return what :func:`load` returns, before it is a dataset, and the part that was followed.

    ``endless``: with the load of cells of an endless beam.
    """
    beam = part.beam
    n = arguments.whole("scales", beam.pitches if scales is None else scales, 2, MANY_SCALES)
    twisting = LOADS["twisting"]
    way = Way.of("twisting", [math.inf])
    analysis = doors.analysis(
        beam.replace(scales=n), way, twisting, points=points, joint=COMPLIANT, mu=mu, ideal=ideal, hold=hold
    )
    beam = analysis.beam
    support = "clamped" if part.support is None else part.support
    given, held = loading.together(part.load, support, beam, n)
    grades = {} if part.along is None else grading.of_scales(part.along, n)
    part = replace(part, beam=beam, along=grades)
    beams = part.graded(n)
    _check_rest([compliant.scale(one, ideal=analysis.ideal) for one in beams], n)
    ones = [compliant.Path.of(one, float(analysis.mus), (NOTHING,), ideal=analysis.ideal) for one in beams]
    told, notes = _solve(ones, n, given, held, points, back=back, endless=endless)
    states = States(told.by_dim(), compliant.attributes(ones[0].held, NOTHING), notes)
    words = "; ".join(g.words.strip() for g in given)
    attrs: dict[str, object] = {"load": "part", "loads": words, "support": support, "pitch": beam.pitch}
    # the whole part, for whoever reads the result
    attrs["beam"] = part.to_toml()
    if grades:
        attrs["graded"] = ", ".join(grades)
    answer = labelled.answer(analysis, states, "a part under load", attrs, load=twisting, page="parts")
    answer.over = tuple(name for name in ("share", "travel", "turn") if name in answer.variables)
    for name, count in (("scale", range(1, n + 1)), ("section", range(n + 1))):
        answer.variables[name] = Labelled((name,), np.array(count), {"long_name": f"{name}, counted along the beam"})
    for name, words in (("axis", "direction"), ("direction", "direction of a section's own axis")):
        answer.variables[name] = Labelled((name,), np.array(["x", "y", "z"]), {"long_name": words})
    return answer, told


def _check_rest(scales: Sequence[path.Scale], n: int) -> None:
    """Refuse scales that touch at rest, before their joints are known, which may take minutes by elements."""
    way = _whole([path.Path.at_rest(one, np.eye(9), 0.0) for one in scales])
    rest = row.tied(way, n, row.legs(np.array([1e-9]), PHI), None, np.zeros((n, STRAINS)), about=EQUAL)
    if rest.end.code == increments.AT_REST:
        where = "along" if len(scales) > 1 else "scale"
        refuse(where, "", "scales touch before anything is loaded", "let them differ less")


def _whole(ways: Sequence[path.Path]) -> path.Path:
    """Return the way of a part from those of its scales, or of one where all are alike."""
    parts = zip(*(way.beams for way in ways), strict=True)
    return ways[0]._replace(beams=entry.Beams._make(map(np.concatenate, parts)))


def _solve(
    ones: Sequence[compliant.Path],
    n: int,
    given: Sequence[Load],
    held: Support,
    points: int,
    *,
    back: bool,
    endless: bool,
) -> tuple[Told, list[str]]:
    """Follow a part to all of its load and back; return it with notes on its model."""
    one = ones[0]
    if len(one.held.K) < 9:
        refuse("joint", "", "joint.matrix knows no bend", "squama joint --matrix writes all nine motions")
    way = _whole([each.way for each in ones])
    units = one.beam.pitch, one.unit_moment / one.beam.pitch, one.unit_moment
    course = loaded.course(way, n, given, held, units)
    last, on = course.asked()
    at = np.linspace(0.0, last, points + 1)
    told = Told.of(ones, given[0], course, np.append(at, at[-2::-1]) if back else at, on=on, endless=endless)
    if back and course.loads and (told.load[points:] < 0).any():
        # friction holds the part deformed when the load is off
        free = points + int(np.flatnonzero(told.load[points:] < 0)[0])
        rest = float(np.interp(0.0, told.load[[free, free - 1]], told.at[[free, free - 1]]))
        at = np.append(at, np.linspace(last, rest, points + 1)[1:])
        told = Told.of(ones, given[0], course, at, on=on, endless=endless)
    notes = compliant.notes(one.held, one.beam, 0.0, ideal=not one.way.scale.h)
    notes += rows.shifted(one.beam)
    if len(ones) > 1 and one.beam.joint.matrix is not None:
        notes.append("joint.matrix is of one shape: all scales of the part have this joint, whatever their shape")
    if held.word == "gripped" and given[0].turns == PHI:
        bar, long = one.beam.substrate, n * one.beam.pitch
        stiffer = section.clamped_ratio(bar.width, bar.thickness, long, bar.poisson_ratio)
        notes.append(
            "the grips leave the bar's ends free to warp: clamps that hold them plane make a bar without scales "
            f"{number(stiffer)} times as stiff in twist"
        )
    most = float(np.abs(told.track.cells[..., :3]).max())
    if most > compliant.STRAIN_LIMIT:
        strained = f"pitches bend or twist by up to {number(math.degrees(most))} deg"
        notes.append(f"give a smaller load: {strained}, and {compliant.COMPARED}")
    return told, notes
