"""Bending in the plane, for what takes edges as across the beam: `squama.bend` at alpha = 0 by the line on the face."""

import squama


def plane(beam, **asked):
    """Return the curve of a beam whose scales lie across it and whose scaled face keeps its length."""
    return squama.bend(beam.replace(scale={"alpha": 0}), neutral="face", **asked)
