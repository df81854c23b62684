"""The deck in CalculiX's dialect: rigid bodies with a node for their rotation, friction with a stick slope."""

from __future__ import annotations

from squama.fe.deck import STICK, Model, header, mesh_lines, pair_lines, rows, section_lines, step_lines

WORDS = (
    "for CalculiX 2.20 or later: run it with ccx and the name of this file without .inp",
    "every increment prints what squama.fe.ccx reads: corners of the scales, two edges of the bar, reactions",
)


def lines(m: Model) -> list[str]:
    """Return the lines of the deck."""
    out = [*header(m, WORDS), *mesh_lines(m)]
    for i, plate in enumerate(m.plates, start=1):
        out += [f"*NSET, NSET=BODY{i}", *rows([*plate.tied, *plate.nodes])]
    out += section_lines(m)
    for i, plate in enumerate(m.plates, start=1):
        out.append(f"*RIGID BODY, NSET=BODY{i}, REF NODE={plate.ref}, ROT NODE={plate.rot}")
    out.append(f"*RIGID BODY, NSET=TURNED, REF NODE={m.ref}, ROT NODE={m.rot}")
    out += ["*SURFACE INTERACTION, NAME=DRY", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{m.penalty:.9g}"]
    if m.mu > 0:
        out += ["*FRICTION", f"{m.mu:.9g}, {STICK * m.penalty:.9g}"]
    out += pair_lines(m)
    out += ["*BOUNDARY", "FIXED, 1, 3, 0.", f"{m.ref}, 1, 2, 0.", f"{m.rot}, 1, 2, 0."]
    out += [*step_lines(m), "*BOUNDARY", f"{m.rot}, 3, 3, {-m.angle:.9g}"]
    for name, what in (("CORNERS", "U"), ("EDGES", "U"), ("FIXED", "RF")):
        out += [f"*NODE PRINT, NSET={name}", what]
    return [*out, "*NODE FILE", "U", "*EL FILE", "S", "*END STEP"]
