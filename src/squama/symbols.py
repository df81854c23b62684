"""Table of symbols: name, unit, words, TeX and equation of each quantity, for attributes, axes, headers and docs."""

from __future__ import annotations

from typing import NamedTuple


class Symbol(NamedTuple):
    """A quantity: ``name`` in code, SI ``unit`` (1 for a ratio), ``long_name``, ``tex``, ``equation`` (its source)."""

    name: str
    unit: str
    long_name: str
    tex: str
    equation: str = ""

    @property
    def attrs(self) -> dict[str, str]:
        """Attributes of a dataset variable."""
        words = {"long_name": self.long_name, "units": self.unit}
        return {**words, "equation": self.equation} if self.equation else words

    @property
    def axis(self) -> str:
        """Label of an axis: long name, symbol and unit."""
        unit = "" if self.unit == "1" else f" ({self.unit})"
        return f"{self.long_name[0].upper()}{self.long_name[1:]} ${self.tex}${unit}"


_TABLE: tuple[tuple[str, ...], ...] = (
    ("eta", "1", "overlap ratio l/d", r"\eta"),
    ("beta", "1", "half width of a scale over the pitch", r"\beta"),
    ("lam", "1", "half thickness of the substrate over the pitch", r"\lambda"),
    ("zeta", "1", "embedded length over the pitch", r"\zeta"),
    ("slenderness", "1", "embedded length over the scale's thickness", r"L/t_s"),
    ("alpha", "rad", "angle between cross-section and scale width", r"\alpha"),
    ("theta0", "rad", "initial inclination of the scales", r"\theta_0"),
    ("mu", "1", "coefficient of friction", r"\mu"),
    ("margin", "1", "cut-off before a lock, as a fraction of the path", "m", "theory: energy"),
    ("theta", "rad", "inclination of the scales", r"\theta", "paper Eq. 6"),
    ("phi", "rad", "twist per pitch", r"\varphi", "paper Eq. 6"),
    ("Phi", "rad/m", "twist rate", r"\Phi"),
    ("T", "N m", "torque", "T", "paper Eq. 14"),
    ("T_scales", "N m", "torque of the scales", "T_s", "paper Eq. 14"),
    ("K_t", "N m^2", "tangent torsional stiffness dT/dPhi", r"\mathrm{d}T/\mathrm{d}\Phi", "paper Eq. 14"),
    ("psi", "rad", "bend per pitch", r"\psi", "theory: bending"),
    ("kappa", "rad/m", "curvature", r"\kappa", "theory: bending"),
    ("M", "N m", "bending moment", "M", "theory: bending"),
    ("M_scales", "N m", "bending moment of the scales", "M_s", "theory: bending"),
    ("K_b", "N m^2", "tangent bending stiffness dM/dkappa", r"\mathrm{d}M/\mathrm{d}\kappa", "theory: bending"),
    ("chi", "rad", "lateral bend per pitch", r"\chi", "theory: contacts"),
    ("M_lat", "N m", "lateral bending moment", r"M_\chi", "theory: contacts"),
    ("stretch", "1", "stretch of the line in the middle of the bar", r"\epsilon", "theory: combined"),
    ("P", "N", "axial force", "P", "theory: contacts"),
    ("N", "N", "normal force of a contact", "N", "paper Eqs. 7, 12"),
    ("f", "N", "friction force of a contact", "f", "paper Eq. 12"),
    ("f0", "1", "friction force f l/K_theta", r"\bar{f}_0", "paper Eq. 12"),
    ("p", "m", "place of the contact on the tip edge, from its middle", "p", "paper Eqs. 2, 5"),
    ("s", "m", "place of the contact on the side edge, from its base", "s", "paper Eqs. 4, 5"),
    ("r", "m", "place of the contact on the face, from its base", "r", "theory: bending"),
    ("mu_lock", "1", "coefficient of friction that locks the contact here", r"\mu_\mathrm{lock}", "theory: forces"),
    ("u_X", "m", "move of a scale's base along n_X", "u_X", "theory: compliant joint"),
    ("u_Y", "m", "move of a scale's base along n_Y", "u_Y", "theory: compliant joint"),
    ("u_Z", "m", "move of a scale's base along n_Z", "u_Z", "theory: compliant joint"),
    ("w_X", "rad", "roll of a scale, rotation vector along n_X", "w_X", "theory: compliant joint"),
    ("w_Y", "rad", "turn of a scale about its width, rotation vector along n_Y", "w_Y", "theory: compliant joint"),
    ("w_Z", "rad", "yaw of a scale, rotation vector along n_Z", "w_Z", "theory: compliant joint"),
    ("K_theta", "N m", "stiffness of a scale's joint", r"K_\theta", "theory: joint"),
    (
        "rigidity",
        "N m^2",
        "tangent torsional stiffness without contact",
        r"\mathrm{d}T_0/\mathrm{d}\Phi",
        "theory: joint",
    ),
    ("stiffness_ratio", "1", "tangent stiffness over that without contact", r"K_t/K_0", "theory: thick scales"),
    ("slip", "m", "length along which a contact has slid", "", "theory: thick scales"),
    ("scale_twist", "rad", "turn of a scale's tip about its length", "", "theory: thick scales"),
    ("deflection", "m", "deflection of the middle of a scale's tip", "w", "theory: thick scales"),
    ("stress", "Pa", "largest stress in a scale (von Mises)", r"\sigma", "theory: thick scales"),
    ("stress_x", "m", "place of largest stress along a scale, from its base", r"x_\sigma", "theory: thick scales"),
    ("stress_y", "m", "place of largest stress across a scale, from its middle", r"y_\sigma", "theory: thick scales"),
    ("strain", "1", "largest strain of the substrate around a scale", r"\varepsilon", "theory: thick scales"),
    ("pull_out", "N", "force that pulls a scale out of the substrate", "P", "theory: thick scales"),
    ("tab_force", "N", "force on the embedded part of a scale", "F", "theory: thick scales"),
    ("tab_bending", "N m", "bending moment on a scale's embedded part, about n_Y", "M_Y", "theory: thick scales"),
    ("tab_torsion", "N m", "twisting moment on a scale's embedded part, about n_X", "M_X", "theory: thick scales"),
    ("gap", "m", "least distance between the scales", "g"),
    ("W", "J/m", "work of the torque per length", "W", "paper Eq. 13"),
    ("U_el", "J/m", "elastic energy per length", r"U_\mathrm{el}", "paper Eq. 15a"),
    ("U_joint", "J/m", "elastic energy of the scales' joints per length", r"U_\mathrm{joint}", "theory: thick scales"),
    ("U_plate", "J/m", "elastic energy of the scales per length", r"U_\mathrm{plate}", "theory: thick scales"),
    ("U_bar", "J/m", "elastic energy of the bar without contact per length", r"U_\mathrm{bar}", "theory: thick scales"),
    ("W_fr", "J/m", "frictional work per length", r"W_\mathrm{fr}", "paper Eq. 15b"),
    ("W_snap", "J/m", "energy per length lost where scales jump to another state", r"W_\mathrm{snap}"),
    ("finite_ratio", "1", "torque or moment of N scales over that of the endless beam", "r_N", "theory: a finite row"),
    (
        "finite_stiffness_ratio",
        "1",
        "tangent stiffness with the beam's own N scales over that without contact",
        "K_N/K_0",
        "theory: a finite row",
    ),
    ("finite_torque", "N m", "torque or moment with the beam's own N scales", "T_N", "theory: a finite row"),
    ("RED", "1", "relative energy dissipation", r"\mathrm{RED}", "paper Eq. 16"),
    ("dphi_dtheta", "1", "twist per inclination", r"\mathrm{d}\varphi/\mathrm{d}\theta", "paper Eq. 6"),
    ("dr_dtheta", "1", "slip per inclination, in pitches", r"\mathrm{d}r/\mathrm{d}\theta", "paper Eq. 10"),
    ("phi_e", "rad", "twist per pitch at engagement", r"\varphi_e", "paper Eq. 6"),
    ("phi_e_other", "rad", "twist per pitch at engagement of the other face", r"\varphi_e'", "theory: both faces"),
    ("phi_e_small", "rad", "twist at engagement, small-angle formula", r"\varphi_e", "paper section 2.2"),
    ("Phi_e", "rad/m", "twist rate at engagement", r"\Phi_e"),
    ("phi_end", "rad", "twist per pitch at the end", r"\varphi_\mathrm{end}"),
    ("Phi_end", "rad/m", "twist rate at the end", r"\Phi_\mathrm{end}"),
    ("phi_twofold", "rad", "twist per pitch at twice the stiffness without contact", r"\varphi_{2\times}"),
    ("phi_fivefold", "rad", "twist per pitch at five times the stiffness without contact", r"\varphi_{5\times}"),
    ("phi_strength", "rad", "twist per pitch at which a scale's stress reaches its strength", r"\varphi_\sigma"),
    ("phi_strain", "rad", "twist per pitch at which the substrate's strain reaches its limit", r"\varphi_\varepsilon"),
    ("phi_second", "rad", "twist per pitch at which a second contact comes in", r"\varphi_2"),
    ("phi_bent", "rad", "twist per pitch at which a scale is bent by a tenth of its length", r"\varphi_w"),
    ("phi_peak", "rad", "twist per pitch at the torque's peak", r"\varphi_\mathrm{peak}"),
    ("psi_e", "rad", "bend per pitch at engagement", r"\psi_e", "theory: bending"),
    ("psi_e_other", "rad", "bend per pitch at engagement of the other face", r"\psi_e'", "theory: both faces"),
    ("kappa_e", "rad/m", "curvature at engagement", r"\kappa_e"),
    ("psi_end", "rad", "bend per pitch at the end", r"\psi_\mathrm{end}"),
    ("kappa_end", "rad/m", "curvature at the end", r"\kappa_\mathrm{end}"),
    ("psi_twofold", "rad", "bend per pitch at twice the stiffness without contact", r"\psi_{2\times}"),
    ("psi_fivefold", "rad", "bend per pitch at five times the stiffness without contact", r"\psi_{5\times}"),
    ("psi_strength", "rad", "bend per pitch at which a scale's stress reaches its strength", r"\psi_\sigma"),
    ("psi_strain", "rad", "bend per pitch at which the substrate's strain reaches its limit", r"\psi_\varepsilon"),
    ("psi_second", "rad", "bend per pitch at which a second contact comes in", r"\psi_2"),
    ("psi_bent", "rad", "bend per pitch at which a scale is bent by a tenth of its length", r"\psi_w"),
    ("psi_peak", "rad", "bend per pitch at the moment's peak", r"\psi_\mathrm{peak}"),
    ("phi_touch", "rad", "twist per pitch at which another pair touches", r"\varphi_\mathrm{touch}"),
    ("psi_touch", "rad", "bend per pitch at which another pair touches", r"\psi_\mathrm{touch}"),
    ("theta_touch", "rad", "inclination at which another pair touches", r"\theta_\mathrm{touch}"),
    ("theta_end", "rad", "inclination at the end", r"\theta_\mathrm{end}"),
    ("theta_c", "rad", "inclination at the cut-off", r"\theta_c", "theory: energy"),
    ("Phi_c", "rad/m", "twist rate at the cut-off", r"\Phi_c", "theory: energy"),
    ("kappa_c", "rad/m", "curvature at the cut-off", r"\kappa_c", "theory: energy"),
    ("T_c", "N m", "torque at the cut-off", "T_c", "paper Eq. 14"),
    ("M_c", "N m", "bending moment at the cut-off", "M_c", "theory: bending"),
    ("stiffening", "1", "load at the cut-off over that of the beam without contact", "T/T_0"),
    ("U_el_c", "J/m", "elastic energy per length at the cut-off", r"U_\mathrm{el}", "paper Eq. 15a"),
    ("W_fr_c", "J/m", "frictional work per length at the cut-off", r"W_\mathrm{fr}", "paper Eq. 15b"),
    ("RED_c", "1", "relative energy dissipation at the cut-off", r"\mathrm{RED}", "paper Eq. 16"),
    ("mu_static", "1", "coefficient of friction that locks at engagement", r"\mu_\mathrm{static}", "theory: forces"),
    ("end", "", "how the curve ends", ""),
    ("neighbour", "1", "neighbour whose contact is followed; 0 for none", "k"),
    ("first_contact", "", "pair of plates that touches first", ""),
    ("energy_error", "1", "work not stored, dissipated or lost in snaps, over all work or the largest energy", ""),
    ("other_contact", "", "pair of plates that comes in from elsewhere", ""),
    ("branch", "", "state in which the point was reached: straight, loading, unloading, stick", ""),
    ("leg", "1", "way between two twists of the history, counted from 1", "i"),
    ("sense", "", "sense of loading", ""),
    ("phi_base", "rad", "twist per pitch at which a loop closes", r"\varphi_1", "theory: cycles"),
    ("phi_top", "rad", "largest twist per pitch of a loop", r"\varphi_2", "theory: cycles"),
    ("phi_residual", "rad", "twist per pitch left when let go at the top", r"\varphi_r", "theory: cycles"),
    ("phi_jam", "rad", "smallest twist per pitch that is not given back", r"\varphi_j", "theory: cycles"),
    ("phi_most", "rad", "largest twist per pitch of a history", r"\varphi_m", "theory: cycles"),
    ("T_drop", "N m", "drop of the torque where a loop turns at its top", r"\Delta T", "theory: cycles"),
    ("psi_base", "rad", "bend per pitch at which a loop closes", r"\psi_1", "theory: cycles"),
    ("psi_top", "rad", "largest bend per pitch of a loop", r"\psi_2", "theory: cycles"),
    ("psi_residual", "rad", "bend per pitch left when let go at the top", r"\psi_r", "theory: cycles"),
    ("psi_jam", "rad", "smallest bend per pitch that is not given back", r"\psi_j", "theory: cycles"),
    ("psi_most", "rad", "largest bend per pitch of a history", r"\psi_m", "theory: cycles"),
    ("M_drop", "N m", "drop of the moment where a loop turns at its top", r"\Delta M", "theory: cycles"),
    ("T_periodic", "N m", "torque of the endless beam", "T"),
    ("M_periodic", "N m", "moment of the endless beam", "M"),
    ("theta_periodic", "rad", "inclination of the scales of the endless beam", r"\theta"),
    ("Q", "N m", "moment by which the substrate holds a scale that lies on it", "Q"),
    ("phi_cell", "rad", "twist of a cell", r"\varphi_i", "theory: a finite row"),
    ("psi_cell", "rad", "bend of a cell", r"\psi_i", "theory: a finite row"),
    ("chi_cell", "rad", "lateral bend of a cell", r"\chi_i", "theory: a finite row"),
    ("stretch_cell", "1", "stretch of a cell", r"\epsilon_i", "theory: a finite row"),
    ("T_cell", "N m", "torque that a cell carries", "T_i", "theory: a finite row"),
    ("M_cell", "N m", "bending moment that a cell carries", "M_i", "theory: a finite row"),
    ("M_lat_cell", "N m", "lateral bending moment that a cell carries", r"M_{\chi,i}", "theory: a finite row"),
    ("P_cell", "N", "axial force that a cell carries", "P_i", "theory: a finite row"),
    ("decay", "1", "factor per scale by which the effect of an end decays, at engagement", "", "theory: a finite row"),
    ("scale_end", "1", "scale whose contact ends the row, or to which another contact comes first; 0 for none", ""),
    ("contact", "", "pair of a scale and the next one that touches", "", "theory: combined"),
    ("state", "", "open, sliding, or what ends the way to it from rest", ""),
    ("event", "", "what happens on the way", ""),
    ("event_leg", "1", "way of the path on which it happens, counted from 1", "i"),
    ("event_scale", "1", "scale whose contact it is, counted from 1; 0 for the whole beam", ""),
    ("psi_event", "rad", "bend per pitch at the event", r"\psi"),
    ("phi_event", "rad", "twist per pitch at the event", r"\varphi"),
    ("kappa_event", "rad/m", "curvature at the event", r"\kappa"),
    ("Phi_event", "rad/m", "twist rate at the event", r"\Phi"),
    ("theta_event", "rad", "inclination at the event", r"\theta"),
    ("M_jump", "N m", "jump of the bending moment there", r"\Delta M"),
    ("T_jump", "N m", "jump of the torque there", r"\Delta T"),
    ("W_d", "J/m", "energy dissipated in a loop, per length", r"W_d", "theory: cycles"),
    ("U_max", "J/m", "elastic energy at the top of a loop, per length", r"U_\mathrm{max}", "theory: cycles"),
    ("zeta_eq", "1", "equivalent viscous damping ratio W_d/(4 pi U_max)", r"\zeta_\mathrm{eq}", "theory: cycles"),
    ("share", "1", "applied share of the load", r"\lambda", "theory: parts"),
    ("share_e", "1", "share of the load at which scales first touch", r"\lambda_e", "theory: parts"),
    ("F", "N", "force of the load", "F", "theory: parts"),
    ("F_bare", "N", "force of the load without contact, at the same travel", "F_0", "theory: parts"),
    ("travel", "m", "travel of the loaded place in the direction of the load", "u", "theory: parts"),
    ("moment", "N m", "torque or moment of the load", "M_P", "theory: parts"),
    ("moment_bare", "N m", "torque or moment of the load without contact, at the same turn", "M_0", "theory: parts"),
    ("turn", "rad", "angle by which the load turns the ends", r"\vartheta", "theory: parts"),
    ("x_axis", "m", "place of the bar's axis along the width", "x", "theory: parts"),
    ("y_axis", "m", "place of the bar's axis towards the scaled side", "y", "theory: parts"),
    ("z_axis", "m", "place of the bar's axis along the bar at rest", "z", "theory: parts"),
    ("root_force", "N", "force that holds the root", "R", "theory: parts"),
    ("root_moment", "N m", "moment that holds the root", "M_R", "theory: parts"),
    ("K_sec", "N m^2", "secant stiffness of a loop", r"K_\mathrm{sec}", "theory: cycles"),
    ("t", "s", "time", "t"),
    ("phi_speed", "rad/s", "rate of the twist per pitch", r"\dot{\varphi}", "theory: vibration"),
    ("phi_turn", "rad", "twist per pitch at a turning point", r"\varphi_n", "theory: vibration"),
    ("phi_rest", "rad", "twist per pitch at which the beam stays", r"\varphi_r", "theory: vibration"),
    ("phi_high", "rad", "largest twist per pitch of a period", r"\varphi_\mathrm{max}", "theory: vibration"),
    ("phi_low", "rad", "smallest twist per pitch of a period", r"\varphi_\mathrm{min}", "theory: vibration"),
    (
        "phi_static",
        "rad",
        "twist per pitch that the torque's amplitude gives the bare beam at rest",
        r"\varphi_F",
        "theory: vibration",
    ),
    ("psi_speed", "rad/s", "rate of the bend per pitch", r"\dot{\psi}", "theory: vibration"),
    ("psi_turn", "rad", "bend per pitch at a turning point", r"\psi_n", "theory: vibration"),
    ("psi_rest", "rad", "bend per pitch at which the beam stays", r"\psi_r", "theory: vibration"),
    ("psi_high", "rad", "largest bend per pitch of a period", r"\psi_\mathrm{max}", "theory: vibration"),
    ("psi_low", "rad", "smallest bend per pitch of a period", r"\psi_\mathrm{min}", "theory: vibration"),
    (
        "psi_static",
        "rad",
        "bend per pitch that the torque's amplitude gives the bare beam at rest",
        r"\psi_F",
        "theory: vibration",
    ),
    ("t_turn", "s", "time of a turning point", "t_n", "theory: vibration"),
    ("U_turn", "J", "elastic energy of the beam at a turning point", "U_n", "theory: vibration"),
    ("zeta_cycle", "1", "damping ratio of a cycle by the energies at its peaks", r"\zeta_n", "theory: vibration"),
    ("period", "s", "time between two peaks", "T_n", "theory: vibration"),
    ("f_0", "Hz", "frequency of the beam without contact", "f_0", "theory: vibration"),
    ("frequency", "Hz", "frequency of the torque", "f", "theory: vibration"),
    ("way", "", "way through the frequencies: up, down", ""),
    ("W_fed", "J", "work of the torque over a period", "W_f", "theory: vibration"),
    ("W_rubbed", "J", "work of friction over a period", r"W_\mu", "theory: vibration"),
    ("W_damped", "J", "work of the material's damping over a period", r"W_\zeta", "theory: vibration"),
    ("periods", "1", "periods until the state was steady", ""),
    ("settled", "", "whether the state was steady", ""),
    ("turns", "1", "smooth parts of the way in a period; 0 without contact", ""),
)

OTHER = "_other"
"""Ending of the names of quantities of a scale on the other face."""
OF_A_SCALE = (
    *("theta", "contact", "N", "f", "f0", "p", "s", "mu_lock", "u_X", "u_Y", "u_Z", "w_X", "w_Y", "w_Z", "slip", "Q"),
    *("deflection", "scale_twist", "stress", "stress_x", "stress_y", "strain"),
    *("pull_out", "tab_force", "tab_bending", "tab_torsion"),
)
"""Quantities of a single scale, by role; a beam with scales on both faces has them for each face."""


def _of_other_face(symbol: Symbol) -> Symbol:
    """Return the symbol of a scale's quantity for the other face."""
    tex = f"{symbol.tex}'" if symbol.tex else ""
    words = f"{symbol.long_name}, of the other face"
    return Symbol(symbol.name + OTHER, symbol.unit, words, tex, "theory: both faces")


SYMBOLS = {row[0]: Symbol(*row) for row in _TABLE}
"""Symbols by their name in code."""
SYMBOLS |= {one.name: one for one in (_of_other_face(SYMBOLS[name]) for name in (*OF_A_SCALE, "r"))}
