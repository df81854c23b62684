"""The table of models, and the rule which one is used: thick, elastic scales unless hinges are meant."""

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
    """What a model does.

    ``solve`` gives a solved path for each coefficient of friction, and what attributes and warnings it adds, on hinges
    of the scaled face alone, and ``gather`` those of the whole beam by these; ``walk`` the states of a history of one
    load, ``polygon`` those of bends and twists one after the other, ``plane`` those at bends and twists (n,). ``case``:
    what a beam brings to a load; ``far``: twist per pitch, rad, to which a bent beam is twisted.
    """

    solve: Callable[[Analysis], tuple[Sequence[Solved], States]]
    gather: Callable[[Analysis, Any], Sequence[Solved]]
    walk: Callable[[Analysis], States]
    polygon: Callable[[Analysis], States]
    plane: Callable[[Analysis, Array, Array], States]
    case: Callable[[Beam, Load], Case]
    far: float


class Model(NamedTuple):
    """A way to hold a scale, and what is known of it.

    ``pages`` of the theory by load, empty for the paper's own; ``thick``: loads in which thickness counts; ``elastic``:
    whether scales bend; ``straight``: whether a beam is held so; ``lines`` of the bar that may keep their length, and
    ``ends`` of a beam with a number of scales, the first by default; ``programs`` are imported when they are asked for.
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
    # by the contact solver, which is compiled: other questions of hinges are answered without it
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
"""A hinge with one spring (closed form), or six motions of a scale against the substrate."""


class Chosen(NamedTuple):
    """A beam and the model that answers: its joint, a key of :data:`MODELS`, and whether scales are thin and rigid.

    ``beam`` knows the line of its bar that keeps its length; ``note``: why it is hinges where nobody asks for them.
    """

    beam: Beam
    joint: str
    ideal: bool
    note: str

    @property
    def compliant(self) -> bool:
        """Whether the model is that of thick, elastic scales, which nothing holds straight unless asked for."""
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
    """Return by which model a beam is answered; refuse what does not go together, or a joint that is not known.

    ``load``: the one load, twisting and bending at once if not given; ``law``, ``joint``, ``ideal``, ``neutral`` as of
    :func:`squama.twist` and :func:`squama.bend`, ``free`` as of :func:`squama.bend_twist`; ``elements``: whether these
    may make the joint of a beam that the law does not know.
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
    """Return a beam that knows which line of its bar keeps its length; by default the first that the joint has."""
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
    """Whether scales are taken as thin: as asked, or because the model knows of no thickness."""
    return ideal or law == "plate" or load.name not in MODELS[joint].thick


def idealisation(beam: Beam, joint: str, *, ideal: bool) -> str:
    """Say in words how a beam's scales are taken by a model."""
    if ideal:
        return THIN
    elastic = MODELS[joint].elastic and beam.scale.youngs_modulus is not None
    return f"thick, {'elastic' if elastic else 'rigid'} scales"
