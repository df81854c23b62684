"""Results as JSON: valid everywhere, so no number (NaN) is null and infinity is the text "inf"."""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from squama.answer import Answer
    from squama.design import Beam


def show(record: Mapping[str, Any]) -> None:
    """Print a record on standard output, nothing else."""
    sys.stdout.write(json.dumps(plain(record), allow_nan=False, indent=1) + "\n")


def plain(value: Any) -> Any:
    """Return nested values as JSON knows them."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "inf" if value > 0 else "-inf"
    return value


def response(file: str, beam: Beam, law: str, laws: Mapping[str, Answer], written: Sequence[str]) -> dict[str, Any]:
    """Return all there is to say about a twisted or bent beam.

    Parameters
    ----------
    file : str
        The beam's file.
    beam : Beam
        The beam as computed, flags included.
    law : str
        The law whose curve is given.
    laws : mapping
        Responses by law.
    written : sequence of str
        The files that were written.

    Returns
    -------
    dict
        ``figures``: single figures of the curve, a list of them each for a family over ``mu``; ``laws``: the same for
        each law; ``curve``: the points, a list of lists for a family; ``units`` for all of them; ``beam``: the input in
        SI units and radians; ``derived``: what follows from it.
    """
    data = laws[law]
    twisting = data.attrs["load"] == "twisting"
    derived: dict[str, Any] = {
        **beam.ratios,
        "zeta": beam.zeta,
        "slenderness": beam.slenderness,
        "length": beam.length,
        "K_theta": beam.joint_stiffness if twisting else beam.bending_joint_stiffness,
        "rigidity": beam.torsional_rigidity if twisting else beam.bending_rigidity,
    }
    if twisting:
        derived |= {"C_f": beam.C_f, "C_w": beam.C_w, "J": beam.J, "I": beam.I, "G_B": beam.G_B}
    if data.attrs.get("joint") == "compliant":
        from squama.cli import joints

        derived |= {key: data.attrs[key] for key in ("K_theta", "rigidity")}
        derived |= {"hinge": joints.compared(laws)}
    return {
        "file": file,
        **{key: data.attrs[key] for key in ("load", "law", "joint", "sense", "margin") if key in data.attrs},
        "squama_version": data.attrs["squama_version"],
        "mu": data["mu"],
        "warnings": data.attrs["warnings"].splitlines(),
        "beam": beam.model_dump(),
        "derived": derived,
        "figures": _figures(data),
        "laws": {name: _figures(response) for name, response in laws.items()},
        "curve": data.curves,
        "units": {name: variable.attrs.get("units", "") for name, variable in data.variables.items()},
        "written": list(written),
    }


def _figures(data: Answer) -> dict[str, Any]:
    from squama.model.outcome import SENTENCES, End

    figures: dict[str, Any] = data.figures
    ends = figures["end"].tolist()
    figures["sentence"] = [SENTENCES[End(end)] for end in ends] if isinstance(ends, list) else SENTENCES[End(ends)]
    return figures
