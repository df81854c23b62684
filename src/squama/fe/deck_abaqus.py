"""The deck in Abaqus' dialect. It follows the keyword reference; it was never run in Abaqus."""

from __future__ import annotations

from squama.fe.deck import Model, header, mesh_lines, pair_lines, rows, section_lines, step_lines

WORDS = (
    "for Abaqus/Standard: THIS DECK WAS NEVER RUN IN ABAQUS, only its syntax was checked; look at the contact in",
    "every increment before you trust a curve",
)


def lines(m: Model) -> list[str]:
    """Return the lines of the deck."""
    out = [*header(m, WORDS), *mesh_lines(m)]
    for i, plate in enumerate(m.plates, start=1):
        out += [f"*NSET, NSET=TIED{i}", *rows(plate.tied)]
        out += [f"*NSET, NSET=REF{i}", str(plate.ref), f"*ELSET, ELSET=SCALE{i}", f"PLATE{i}, STRIP{i}"]
    out += ["*NSET, NSET=HAND", str(m.ref), *section_lines(m)]
    for i, plate in enumerate(m.plates, start=1):
        out.append(f"*RIGID BODY, REF NODE={plate.ref}, ELSET=SCALE{i}, PIN NSET=TIED{i}")
    out.append(f"*RIGID BODY, REF NODE={m.ref}, PIN NSET=TURNED")
    out += ["*SURFACE INTERACTION, NAME=DRY", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", f"{m.penalty:.9g}"]
    if m.mu > 0:
        out += ["*FRICTION", f"{m.mu:.9g}"]
    out += pair_lines(m)
    out += ["*BOUNDARY", "FIXED, 1, 3, 0.", "HAND, 1, 2, 0.", "HAND, 4, 5, 0."]
    out += [*step_lines(m), "*BOUNDARY", f"HAND, 6, 6, {-m.angle:.9g}"]
    out += ["*OUTPUT, FIELD, FREQUENCY=1", "*NODE OUTPUT", "U, RF", "*ELEMENT OUTPUT", "S, LE", "*CONTACT OUTPUT"]
    out += ["CSTRESS, CDISP", "*OUTPUT, HISTORY, FREQUENCY=1", "*NODE OUTPUT, NSET=HAND", "UR3, RM3"]
    for i in range(1, m.scales + 1):
        out += [f"*NODE OUTPUT, NSET=REF{i}", "U1, U2, U3, UR1, UR2, UR3"]
    return [*out, "*END STEP"]
