"""The table of models, and the rule that chooses one: thick, elastic scales unless the arguments imply hinges."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from squama import arguments
from squama.beam.design import Beam
from squama.errors import refuse
from squama.joints import choice
from squama.loads import ENDLESS, ENDS, LINES, LOADS, NEUTRAL, THIN, Load

if TYPE_CHECKING:
    from squama.curves.way import Analysis, Case, Solved, States
    from squama.types import Array

COMPLIANT = "compliant"
"""The joint of thick, elastic scales: the default."""
HINGED = 'write joint="hinge" (--joint hinge)'


class Programs(NamedTuple):
    """Functions of a model.

    ``solve`` returns a solved path for each coefficient of friction, with further attributes and warnings; on hinges it
    covers the scaled face alone, and ``gather`` makes the whole beam's paths from it. ``walk`` returns the states of a
    history of one load, ``polygon`` those along bends and twists in succession, ``plane`` those at bends and twists
    (n,). ``case`` returns a beam's data for a load; ``far`` is the twist per pitch, rad, to which a bent beam is
    twisted.
    """

    solve: Callable[[Analysis], tuple[Sequence[Solved], States]]
    gather: Callable[[Analysis, Any], Sequence[Solved]]
    walk: Callable[[Analysis], States]
    polygon: Callable[[Analysis], States]
    plane: Callable[[Analysis, Array, Array], States]
    case: Callable[[Beam, Load], Case]
    far: float


class Model(NamedTuple):
    """A model of the joint and its properties.

    ``pages`` of the theory by load, "" for the paper's own; ``thick``: loads in which thickness counts; ``elastic``:
    whether scales bend; ``straight``: whether the beam is held straight; ``lines`` of the bar that may keep their
    length, and ``ends`` of a beam with a number of scales, the first by default; ``programs`` imports the functions
    when first used.
    """

    pages: Mapping[str, str]
    thick: tuple[str, ...]
    elastic: bool
    straight: bool
    lines: tuple[str, ...]
    ends: tuple[str, ...]
    programs: Callable[[], Programs]


def _hinge() -> Programs:
    from squama.curves import hinge, hinge_cycles, hinge_polygons
    from squama.curves.way import Case

    return Programs(
        solve=_hinge_solve,
        gather=hinge.gather,
        walk=hinge_cycles.walk,
        polygon=hinge_polygons.polygon,
        plane=hinge_polygons.plane,
        case=lambda beam, load: Case.of(beam, load.name),
        far=1.0,
    )


def _hinge_solve(analysis: Analysis) -> tuple[Sequence[Solved], States]:
    from squama.curves import hinge

    if analysis.ends == ENDLESS:
        return hinge.solve(analysis)
    # by the contact solver, which is compiled; all else on hinges is computed without it
    from squama.curves import hinge_rows

    return hinge_rows.solve(analysis)


def _compliant() -> Programs:
    from squama.contacts.path import RANGE
    from squama.curves import compliant_cycles, compliant_polygons, compliant_walk

    return Programs(
        solve=compliant_walk.solve,
        gather=lambda _, whole: whole,
        walk=compliant_cycles.walk,
        polygon=compliant_polygons.polygon,
        plane=compliant_walk.plane,
        case=compliant_walk.case,
        far=RANGE,
    )


MODELS = {
    "hinge": Model(
        pages={"twisting": "", "bending": "bending"},
        thick=("twisting",),
        elastic=False,
        straight=True,
        lines=tuple(NEUTRAL),
        ends=(ENDLESS, "equal"),
        programs=_hinge,
    ),
    COMPLIANT: Model(
        pages=dict.fromkeys(LOADS, "thick scales"),
        thick=tuple(LOADS),
        elastic=True,
        straight=False,
        lines=("free", "middle"),
        ends=ENDS,
        programs=_compliant,
    ),
}
"""Models by joint: a hinge with one spring (closed form), or six motions of a scale against the substrate."""


class Chosen(NamedTuple):
    """A beam and its model: the joint, a key of :data:`MODELS`, and whether scales are thin and rigid.

    ``beam`` has the line of its bar that keeps its length; ``note`` is the reason for hinges that were not requested.
    """

    beam: Beam
    joint: str
    ideal: bool
    note: str

    @property
    def compliant(self) -> bool:
        """Whether the model is that of thick, elastic scales, in which a beam is held straight only on request."""
        return not MODELS[self.joint].straight


def chosen(
    beam: Beam,
    load: Load | None = None,
    *,
    law: str = "edge",
    joint: str | None = None,
    ideal: bool | None = None,
    neutral: str | None = None,
    free: str | None = None,
    elements: bool = True,
) -> Chosen:
    """Return the model of a beam; refuse arguments that exclude each other, and an unknown joint.

    ``load``: the one load, None for twisting and bending at once; ``law``, ``joint``, ``ideal``, ``neutral`` as in
    :func:`squama.twist` and :func:`squama.bend`, ``free`` as in :func:`squama.bend_twist`; ``elements``: whether finite
    elements may compute a joint outside the law's range.
    """
    arguments.held(joint, ideal)
    if neutral is not None:
        arguments.one_of("neutral", neutral, tuple(LINES))
    bends, line = load is not LOADS["twisting"], neutral or beam.substrate.neutral
    hinged, note = law != "edge" or free is not None or (bends and line == "face"), ""
    if joint is None:
        unknown = choice.impossible if elements else choice.unknown
        note = "" if hinged else unknown(beam) or (choice.unbent(beam) if bends else "")
        joint = "hinge" if hinged or note else COMPLIANT
    elif joint == COMPLIANT:
        why = (choice.impossible(beam) if elements else "") or (choice.unbent(beam) if bends else "")
        for name, value, reason, remedy in (
            ("joint", joint, why, HINGED),
            ("law", law, 'is not covered by joint="compliant"' * (law != "edge"), 'write law="edge"'),
            ("free", free, "is for hinges only" * (free is not None), HINGED),
        ):
            if reason:
                refuse(name, f'"{value}"', reason, remedy)
    thin = joint == "hinge" if ideal is None else ideal
    if joint == "hinge" and bends and not thin:
        refuse("ideal", "False", "is not available on hinges in bending", "leave it out")
    if not bends and neutral is not None and joint == "hinge":
        refuse("neutral", f'"{neutral}"', "has no effect on hinges in twisting", "leave it out")
    if bends or neutral is not None:
        beam = _lined(beam, joint, line)
    return Chosen(beam, joint, thin, note)


def _lined(beam: Beam, joint: str, line: str | None) -> Beam:
    """Return the beam with the line of its bar that keeps its length; by default the first one of the joint."""
    lines = MODELS[joint].lines
    line = arguments.one_of("neutral", line or lines[0], lines)
    if joint == "hinge":
        if beam.other and line == "face":
            refuse(
                "neutral",
                f'"{line}"',
                "needs scales on one face; with scales on both it is the middle",
                'write "middle"',
            )
        return beam if beam.neutral == line else beam.replace(substrate={"neutral": line})
    if line == "free" and beam.joint.matrix is not None and len(beam.joint.matrix.K) < 9:
        refuse("neutral", '"free"', "needs a stretch in joint.matrix, which has none", 'write "middle"')
    if beam.given.line == line:
        return beam
    return beam.replace(substrate={"neutral": None if line == "free" else line})


def thin(load: Load, law: str, joint: str, *, ideal: bool) -> bool:
    """Return whether scales are thin in the model: on request, or because the model has no thickness."""
    return ideal or law == "plate" or load.name not in MODELS[joint].thick


def idealisation(beam: Beam, joint: str, *, ideal: bool) -> str:
    """Return in words how a model takes a beam's scales."""
    if ideal:
        return THIN
    elastic = MODELS[joint].elastic and beam.scale.youngs_modulus is not None
    return f"thick, {'elastic' if elastic else 'rigid'} scales"
