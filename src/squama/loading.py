"""Kinds of loading: which variable of a dataset each role of a curve becomes."""

from __future__ import annotations

from typing import NamedTuple


class Loading(NamedTuple):
    """Names of the variables of a kind of loading, by their roles in :mod:`squama.curve`."""

    kind: str
    along: dict[str, str]
    figures: dict[str, str]


_ALONG = {
    "theta": "theta",
    "N": "N",
    "f": "f",
    "f0": "f0",
    "mu_lock": "mu_lock",
    "elastic": "U_el",
    "work": "W_fr",
    "RED": "RED",
}
_FIGURES = {
    "theta_end": "theta_end",
    "theta_c": "theta_c",
    "stiffening": "stiffening",
    "elastic_c": "U_el_c",
    "work_c": "W_fr_c",
    "RED_c": "RED_c",
    "mu_static": "mu_static",
    "end": "end",
    "neighbour": "neighbour",
    "other_contact": "other_contact",
}
TWISTING = Loading(
    "twisting",
    {
        "rate": "Phi",
        "load": "phi",
        "torque": "T",
        "scales": "T_scales",
        "tangent": "K_t",
        "p": "p",
        "s": "s",
        **_ALONG,
    },
    {
        "load_e": "phi_e",
        "rate_e": "Phi_e",
        "load_end": "phi_end",
        "rate_end": "Phi_end",
        "rate_c": "Phi_c",
        "torque_c": "T_c",
        **_FIGURES,
        "load_touch": "phi_touch",
        "theta_touch": "theta_touch",
    },
)
_SKIPPED = {"mu_lock", "mu_static", "load_touch", "theta_touch"}
COMPLIANT = Loading(
    "twisting",
    {role: name for role, name in TWISTING.along.items() if _SKIPPED.isdisjoint((role, name))}
    | {name: name for name in ("u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z", "gap")},
    {role: name for role, name in TWISTING.figures.items() if _SKIPPED.isdisjoint((role, name))}
    | {name: name for name in ("first_contact", "energy_error")},
)
BENDING = Loading(
    "bending",
    {
        "rate": "kappa",
        "load": "psi",
        "torque": "M",
        "scales": "M_scales",
        "tangent": "K_b",
        "s": "r",
        **_ALONG,
    },
    {
        "load_e": "psi_e",
        "rate_e": "kappa_e",
        "load_end": "psi_end",
        "rate_end": "kappa_end",
        "rate_c": "kappa_c",
        "torque_c": "M_c",
        **_FIGURES,
    },
)
