"""What the syntax tree does not give: errors written by hand, which tests a file answers to, what is no error."""

from __future__ import annotations

REFERENCE = ("reference/test_reference.py", "reference/test_cases.py")
WORK = ("unit/test_energy.py", "unit/test_response.py")
PROPERTIES = (
    "properties/test_virtual_work.py",
    "properties/test_first_event.py",
    "properties/test_symmetries.py",
    "properties/test_limits.py",
    "properties/test_many_designs.py",
    "properties/test_joint_limits.py",
)
CYCLES = ("unit/test_cycle.py", "properties/test_cycles.py")
BATCH = tuple(
    f"unit/test_batch.py::{test}"
    for test in (
        "test_single_designs",
        "test_shapes",
        "test_few_and_many_agree",
        "test_neither_place_nor_company_nor_threads_matter",
        "test_a_mistake_in_a_thread_is_not_lost",
    )
)
INVERSE = (
    "unit/test_inverse_figures.py",
    "unit/test_inverse_input.py",
    *(
        f"unit/test_inverse.py::{test}"
        for test in (
            "test_what_cannot_be_reached_names_what_holds_it",
            "test_a_limit_that_holds_the_nearest_beam",
            "test_what_has_no_effect_stays_and_is_named",
            "test_tolerances_against_changed_beams",
            "test_bending_and_the_kind_of_lock",
            "test_a_twist_keeps_its_meaning_while_the_pitch_changes",
            "test_a_curve_and_a_tangent",
        )
    ),
)
UNCERTAIN = (
    *(
        f"unit/test_uncertainty.py::{test}"
        for test in (
            "test_statistics_of_known_values",
            "test_distributions",
            "test_a_normal_distribution_is_truncated_to_what_is_possible",
            "test_quantiles_map_through_a_monotone_function",
            "test_samples_are_beams",
            "test_before_is_an_angle_per_pitch_in_total_or_a_rate",
            "test_what_a_sample_cannot_be_is_refused",
            "test_bad_arguments",
            "test_indices_of_ishigami",
        )
    ),
    "unit/test_uncertainty_cli.py",
    "unit/test_uncertainty.py",
)
TESTS: dict[str, tuple[str, ...]] = {
    "model/twisting.py": ("unit/test_twisting_kernel.py", *REFERENCE),
    "model/laws.py": ("unit/test_laws.py", "unit/test_twisting_kernel.py", *REFERENCE),
    "model/mechanics.py": (
        "unit/test_laws.py",
        "unit/test_bending.py",
        *REFERENCE,
        "unit/test_ends.py",
        *PROPERTIES[:2],
    ),
    "model/bending.py": ("unit/test_bending.py", "unit/test_response.py"),
    "model/paths.py": (
        *REFERENCE,
        "unit/test_ends.py",
        *WORK,
        "unit/test_bending.py",
        "unit/test_api.py",
        *PROPERTIES[:4],
    ),
    "model/energy.py": ("unit/test_energy.py", REFERENCE[1], "unit/test_response.py", PROPERTIES[4]),
    "model/neighbours.py": (*REFERENCE, "unit/test_ends.py", PROPERTIES[4], *PROPERTIES[:3]),
    "model/bracket.py": ("unit/test_bracket.py", "unit/test_ends.py"),
    "model/evaluation.py": (*REFERENCE, "unit/test_ends.py", "unit/test_bending.py", PROPERTIES[4]),
    "model/follow.py": (*REFERENCE, "unit/test_ends.py", "unit/test_bending.py", PROPERTIES[4], *PROPERTIES[:3]),
    "model/figures.py": (
        REFERENCE[1],
        "unit/test_energy.py",
        "unit/test_solve.py",
        PROPERTIES[4],
        "unit/test_batch.py",
    ),
    "model/plates.py": ("unit/test_plates.py", REFERENCE[1], "unit/test_ends.py", PROPERTIES[2]),
    "model/history.py": ("unit/test_history.py", "unit/test_cycle.py", "properties/test_cycles.py"),
    "model/chain.py": ("unit/test_row.py",),
    "model/sensitivity.py": ("unit/test_gradient.py",),
    "model/thickness.py": ("unit/test_plates.py", "unit/test_response.py", "unit/test_ends.py"),
    "model/chain_track.py": ("unit/test_row.py",),
    "model/tracks.py": ("unit/test_gradient.py", "unit/test_inverse_figures.py"),
    "model/section.py": ("unit/test_section_joint.py",),
    "model/joint.py": ("unit/test_section_joint.py", PROPERTIES[5], "unit/test_design.py"),
    "loads.py": ("unit/test_loads.py", "unit/test_follow.py", "unit/test_solve.py", "unit/test_response.py"),
    "errors.py": ("unit/test_errors.py", "unit/test_flags.py", "unit/test_beamfile_errors.py"),
    "arguments.py": ("unit/test_api.py", "unit/test_solve.py", "unit/test_gradient.py", "unit/test_response.py"),
    "arrays/edge_contacts.py": (PROPERTIES[2], "unit/test_api.py", REFERENCE[1]),
    "arrays/derivatives.py": ("unit/test_gradient.py",),
    "arrays/designs_table.py": ("unit/test_designs_table.py",),
    "batch/__init__.py": ("unit/test_solve.py", "unit/test_ends.py", PROPERTIES[4], "unit/test_api.py"),
    "batch/answers.py": ("unit/test_solve.py", *BATCH),
    "arrays/solution.py": (
        REFERENCE[1],
        "unit/test_ends.py",
        "unit/test_solve.py",
        "unit/test_gradient.py",
        PROPERTIES[4],
    ),
    "beam/joint_law.py": ("unit/test_joint_law.py", "unit/test_columns.py", "unit/test_design.py"),
    "beam/parts.py": ("unit/test_design.py", "unit/test_beamfile_errors.py", "unit/test_matrixfile.py"),
    "beam/design.py": ("unit/test_design.py", "unit/test_joint_law.py", "unit/test_response.py"),
    "beam/matrixfile.py": ("unit/test_matrixfile.py", "fe/test_joint_file.py"),
    "beam/validity.py": ("unit/test_design.py", PROPERTIES[5], "unit/test_response.py"),
    "curves/path.py": ("unit/test_follow.py", "unit/test_response.py", *CYCLES),
    "curves/follow.py": ("unit/test_follow.py", "unit/test_response.py", "unit/test_cycle.py"),
    "curves/hinge.py": ("unit/test_response.py", "unit/test_energy.py", "unit/test_follow.py"),
    "curves/hinge_cycles.py": CYCLES,
    "curves/compliant.py": ("fe/test_twist_compliant.py",),
    "curves/compliant_cycles.py": ("fe/test_cycle_compliant.py",),
    "curves/labelled.py": ("unit/test_follow.py", "unit/test_response.py", "unit/test_cycle.py", "unit/test_store.py"),
    "curves/finite_rows.py": ("unit/test_row.py",),
    "curves/doors.py": (
        "unit/test_response.py",
        "unit/test_follow.py",
        "unit/test_cycle.py",
        "unit/test_cli_summary.py",
    ),
    "fe/walk.py": ("fe/test_condense.py", "fe/test_snap.py", "fe/test_cell.py", "fe/test_cycle_compliant.py"),
    "fe/body.py": ("fe/test_body.py", "fe/test_hinged.py", "fe/test_beam.py"),
    "fe/contact.py": ("fe/test_contact.py", "fe/test_row_contact.py", "fe/test_hinged.py"),
    "fe/condense.py": ("fe/test_condense.py", "fe/test_twist_compliant.py", "fe/test_cycle_compliant.py"),
    "fe/solver.py": ("fe/test_solver.py", "fe/test_body.py"),
    "fe/assembly.py": ("fe/test_hinged.py", "fe/test_beam.py", "fe/test_cell.py"),
    "fe/plate.py": ("fe/test_plate.py", "fe/test_row_contact.py", "fe/test_condense.py"),
    "fe/runs.py": ("fe/test_snap.py", "fe/test_cell_input.py", "fe/test_cell.py", "fe/test_beam.py"),
    "fe/stiffness.py": ("fe/test_joint.py", "fe/test_joint_file.py"),
    "fe/agreement.py": ("unit/test_compare.py", "fe/test_verify.py"),
    "fe/balance.py": ("fe/test_balance.py", "fe/test_condense.py", "fe/test_hinged.py"),
    "fe/elements.py": ("fe/test_elements.py", "fe/test_body.py"),
    "study/plan.py": ("unit/test_sweep.py", "unit/test_map_cli.py"),
    "study/slices.py": ("unit/test_sweep.py", "unit/test_map_cli.py"),
    "study/columns.py": ("unit/test_columns.py", "unit/test_joint_law.py", "unit/test_sweep.py"),
    "study/parameters.py": ("unit/test_sweep.py", "unit/test_map_cli.py", "unit/test_columns.py"),
    "study/store.py": ("unit/test_sweep.py", "unit/test_sweep_resume.py"),
    "study/tolerances/distributions.py": UNCERTAIN,
    "study/tolerances/monte_carlo.py": UNCERTAIN,
    "study/tolerances/statistics.py": UNCERTAIN,
    "identify/forward.py": ("unit/test_fit_branches.py", "unit/test_fit.py"),
    "identify/fitting.py": ("unit/test_fit.py", "unit/test_fit_input.py"),
    "identify/estimate.py": ("unit/test_fit_branches.py", "unit/test_fit.py"),
    "identify/records.py": ("unit/test_fit_branches.py", "unit/test_fit_input.py", "unit/test_fit.py"),
    "inverse/figures.py": INVERSE,
    "inverse/residuals.py": INVERSE,
    "inverse/goals.py": INVERSE,
    "inverse/limits.py": INVERSE,
    "inverse/space.py": ("unit/test_joint_law.py", *INVERSE),
    "inverse/front.py": ("unit/test_inverse_front.py",),
    "io/measured.py": ("unit/test_measured.py", "unit/test_fit_input.py"),
    "io/tabular.py": ("unit/test_measured.py", "unit/test_designs_table.py", "unit/test_store.py"),
    "fabrication/measure.py": ("unit/test_export_solids.py", "unit/test_export.py"),
    "cli/flags.py": ("unit/test_flags.py", "unit/test_cli_summary.py", "unit/test_cli_errors.py", "unit/test_cli.py"),
    "cli/output.py": (
        "unit/test_cli_summary.py",
        "unit/test_inverse_input.py::test_the_command_design",
        "unit/test_inverse_input.py::test_the_command_pareto",
        "unit/test_cli.py",
    ),
}
"""Fast tests of each file, those that catch most first (relative to tests)."""

BY_HAND: tuple[tuple[str, str, str], ...] = (
    # dropped friction
    ("model/mechanics.py", "D = -pt.M_N - mu * pt.M_f", "D = -pt.M_N"),
    ("model/mechanics.py", "f = mu * N", "f = 0 * mu * N"),
    (
        "model/mechanics.py",
        "((pt.theta - theta0) * pt.theta_rate + f * pt.slip_rate) / pt.load_rate",
        "(pt.theta - theta0) * pt.theta_rate / pt.load_rate",
    ),
    # a lock that is not looked for
    (
        "model/evaluation.py",
        "(pt.load_rate, f.D, *places, pt.turn))",
        "(abs(pt.load_rate) + 1, f.D, *places, pt.turn))",
    ),
    # the paper's Eq. 7 sign, its arccos, its normals
    ("model/mechanics.py", "N = (pt.theta - theta0) / D", "N = -(pt.theta - theta0) / D"),
    ("model/laws.py", "c.slip_x * c.k_ZX + across", "c.slip_x * c.k_ZX + abs(across)"),
    ("model/laws.py", '{"edge": edge, "plate": plate}', '{"edge": plate, "plate": edge}'),
    ("model/laws.py", "-(c.phi_rate * sqrt(c.per_J2))", "-c.phi_rate"),
    # swapped edges
    ("model/paths.py", "self.beta - abs(pt.p)", "self.eta - abs(pt.p)"),
    ("model/paths.py", "self.eta / 2 - abs(pt.s - self.eta / 2)", "self.eta - pt.s"),
    (
        "model/follow.py",
        "CODES.index(End.OFF_TIP), CODES.index(End.OFF_SIDE)",
        "CODES.index(End.OFF_SIDE), CODES.index(End.OFF_TIP)",
    ),
    ("model/follow.py", "MARGINS = (KINEMATIC, FRICTIONAL,", "MARGINS = (FRICTIONAL, KINEMATIC,"),
    # alpha's sign, the mirror
    ("arrays/solution.py", '(1 if sense == "+" else -1)', "1"),
    ("arrays/edge_contacts.py", "np.sin(alpha) * arguments.sense(sense)", "np.sin(alpha)"),
    ("model/plates.py", "if not mirrored else", "if True else"),
    # neighbours: scaling, the first, the others
    ("model/paths.py", "return self.sa, self.ca, self.eta / self.k", "return self.sa, self.ca, self.eta"),
    ("model/neighbours.py", "& (abs(c.p) <= row.beta / row.k) & (c.s >= 0)", "& (c.s >= 0)"),
    # the fold: its way back, its sign
    ("model/paths.py", "-x * root_E", "abs(x) * root_E"),
    # the margin, the pole, the log
    ("model/energy.py", "x_c = x0 + (1 - margin) * (x_end - x0)", "x_c = x_end + 0 * margin"),
    ("model/energy.py", "np.where(locks, x_c, x_end)", "x_c"),
    ("model/energy.py", "* pt.slip_rate * (x_pole - x)", "* abs(pt.theta_rate) * (x_pole - x)"),
    ("model/section.py", "a, b = max(width, thickness), min(width, thickness)", "a, b = width, thickness"),
)
"""File, text that stands there once, text to put in its place."""

_TUNING = "how closely is looked, not what is found: more or less of it gives the same figures"
_ROUNDING = "a threshold between rounding and what counts: nothing lies between the two values"
_ZERO = "a zero that only gives the shape"
_OUT_OF_REACH = "looks at one neighbour more, which cannot be reached"
_SIGN = "the solver takes brackets of either sign"
_WIDER = "a bracket wider by a sample holds the same valley or crossing"
_MORE = "looks into more valleys between samples than it must"
_NOTHING = "there is no work: whatever the series is stretched over, its terms are zero"

EQUIVALENT: dict[tuple[str, str], dict[str, str]] = {
    ("model/paths.py", "return 1e-300 - x * x / 2"): {
        "1e-300 -> (1e-300 * 1.1)": "keeps 0/0 away: any number too small to be seen does",
    },
    ("model/bending.py", "psi = 0 * theta"): {"* -> /": _ZERO},
    ("model/bending.py", "for _ in range(8):"): {"*": _TUNING},
    ("model/bending.py", "if np.all(abs(step) <= 1e-12 * abs(psi)):"): {
        "1e-12 -> (1e-12 * 1.1)": _ROUNDING,
        "* -> /": "stops later or at the last of the eight steps, at the same digits",
        "abs -> nothing #2": "psi is positive",
    },
    ("model/bending.py", "q=1.0,"): {
        "1.0 -> 2.0": "there is no root of the contact condition in bending; nothing reads it"
    },
    ("model/history.py", "h = 1e-4 * (b - a)"): {
        "1e-4 -> (1e-4 * 1.1)": "the step of an estimate, as in model/energy.py",
        "* -> /": "as above: only how far a pole is stretched to",
    },
    ("model/chain.py", "slip = np.sqrt((V * V).sum(axis=0) + 1e-30)"): {
        "1e-30 -> (1e-30 * 1.1)": "keeps 0/0 away: any number too small to be seen does",
    },
    ("model/history.py", "bottom = _bottom(f, float(x[i - 1]), float(x[i + 1]))"): {
        "1 -> 2": _WIDER,
        "1 -> 2 #2": _WIDER,
    },
    ("model/history.py", "return bracketed(lambda v: float(f(v)), float(x[i + 1]), bottom)"): {"1 -> 2": _WIDER},
    ("model/history.py", "return bracketed(lambda v: float(f(v)), float(x[first + 1]), float(x[first]))"): {
        "1 -> 2": _WIDER,
    },
    ("model/history.py", "bottom = middle - (right - left) ** 2 / (8 * (right + left - 2 * middle))"): {
        "- -> + #2": _MORE,
        "- -> + #3": _MORE,
        "2 -> 1 #2": _MORE,
    },
    ("model/history.py", "dip = (middle <= left) & (middle < right) & (bottom < _DEEP * middle)"): {
        "* -> /": _MORE,
        "& -> | #2": _MORE,
    },
    ("model/history.py", "return np.asarray(i[i > first + 1])"): {
        "+ -> -": "a valley at the last sample below zero ends at the same crossing",
    },
    ("model/history.py", "x = np.linspace(a, b, 33)"): {"33 -> (33 * 2 + 1)": _TUNING},
    ("model/history.py", "SAMPLES = 1025"): {"*": _TUNING},
    ("model/history.py", "_DEEP = 0.5"): {"0.5 -> (0.5 * 1.1)": _TUNING},
    ("model/history.py", "_ROUNDS = 4"): {"4 -> (4 * 2 + 1)": _TUNING},
    ("model/history.py", "return [int(i) + 1 for i in np.flatnonzero(steps[1:] * steps[:-1] < 0)]"): {
        "* -> /": "they are 1 or -1",
        "0 -> 1": "as above: the products are 1 or -1",
    },
    ("model/history.py", "if (b - a) * (value - b) > 0:"): {
        "* -> /": "the same sign; b is never the value here",
    },
    ("model/history.py", "elif (value - a) * (b - a) <= 0:"): {"* -> /": "the same sign; a is never b"},
    ("model/history.py", "del stack[-2:]"): {
        "2 -> 1": "a is taken off in the next round, where it is no turning point any more",
    },
    ("model/energy.py", "TOLERANCE = 1e-11"): {"*": _TUNING},
    ("model/energy.py", "NODES = 64"): {"*": _TUNING},
    ("model/energy.py", "FEW_NODES = 24"): {"*": _TUNING},
    ("model/energy.py", "MOST_NODES = 2048"): {"*": _TUNING},
    ("model/energy.py", "h = 1e-4 * (x_end - x0)"): {
        "1e-4 -> (1e-4 * 1.1)": "the step of an estimate: a pole ahead of the end need not be known well",
        "- -> +": "as above",
    },
    ("model/energy.py", "return h * D1 / ops.larger(D0 - D1, 1e-7 * D1 + 1e-300)"): {
        "1e-7 -> (1e-7 * 1.1)": "far enough that the logarithm is straight",
        "1e-300 -> (1e-300 * 1.1)": "only keeps 0/0 away",
    },
    ("model/figures.py", "PARTS, DEPTH, MOST_PARTS = 16, 6, 32"): {"*": _TUNING},
    ("model/energy.py", "if float(np.abs(c[-4:]).max()) <= TOLERANCE * total:"): {"4 -> (4 * 2 + 1)": _TUNING},
    ("model/energy.py", "total = abs(float(c.sum()))"): {"abs -> nothing": "the work is positive"},
    ("model/energy.py", "if mu == 0 or x_stop <= x0:"): {"or -> and": "the rest gives the same zeros, later"},
    ("model/energy.py", "return Series(np.zeros(1), x0, x0 + 1.0, 1.0)"): {
        "1 -> 2": _NOTHING,
        "+ -> -": _NOTHING,
        "1.0 -> 2.0": _NOTHING,
        "1.0 -> 2.0 #2": _NOTHING,
    },
    (
        "model/neighbours.py",
        "return row.eta * row.ca * (cs + abs(cs)) / 2 + row.beta * (row.sa + abs(row.sa)) + 1e-9",
    ): {"1e-9 -> (1e-9 * 1.1)": _ROUNDING},
    (
        "model/neighbours.py",
        "on = (r.H + q > 0) & (abs(c.p) <= row.beta / row.k) & (c.s >= 0) & (c.s <= row.eta / row.k)",
    ): {
        " / row.k -> nothing #2": "in 480 000 designs no tip came to rest beyond the other scale's tip: s <= eta anyway",  # noqa: E501
        "/ -> * #2": "as above",
    },
    ("model/neighbours.py", "return (abs(c.p) <= row.beta / j) & (c.s >= 0) & (c.s <= row.eta / j)"): {
        " / j -> nothing #2": "in 200 000 designs no crossing lay beyond the other scale's tip: s <= eta anyway",
        "/ -> * #2": "as above",
    },
    ("model/follow.py", "SAMPLES, FOLDED_SAMPLES = 13, 41"): {"*": _TUNING},
    ("model/follow.py", "CLEAR, FOLDED_CLEAR = 5, 13"): {"*": _TUNING},
    ("model/follow.py", "NEAR = 7"): {"*": _TUNING},
    ("model/follow.py", "SAFETY = 0.25"): {"*": _TUNING},
    ("model/follow.py", "DEEP = 0.5"): {"*": _TUNING},
    ("model/follow.py", "COINCIDE = 1e-11"): {"*": _ROUNDING},
    ("model/follow.py", "AWAY = 0.5"): {"*": _TUNING},
    ("model/plates.py", "z = np.stack([ca * ct, sa + 0 * ct, -ca * st])"): {
        "+ -> -": _ZERO,
        "* -> / #2": _ZERO,
        "ct -> st #2": _ZERO,
    },
    (
        "model/plates.py",
        "o = lam * np.stack([S * (-sa * ct) + C1 * st, S * ca + 0 * C1 * st, S * (sa * st) + C1 * ct]) + k * z[:, None]",  # noqa: E501
    ): {"+ -> - #2": _ZERO, "* -> / #6": _ZERO, "* -> / #7": _ZERO, "st -> ct #2": _ZERO},
    ("model/plates.py", "tol = 1e-9 * (eta + beta)"): {"*": _ROUNDING},
    ("model/plates.py", "_ROUNDS = 4"): {"*": _TUNING},
    ("model/plates.py", "_PARALLEL = 1e-14"): {"1e-14 -> (1e-14 * 1.1)": _TUNING},
    ("model/plates.py", "square = da * da + d[2] * d[2] + 1e-300"): {
        "1e-300 -> (1e-300 * 1.1)": "keeps 0/0 away: any number too small to be seen does",
    },
    ("model/plates.py", "within = abs(v) <= beta + tol if e < 2 else (v >= -tol) & (v <= eta + tol)"): {
        "- -> nothing": _ROUNDING,
    },
    (
        "model/plates.py",
        "plates: Plates, at: Callable[[Array], tuple[Array, Array]], x: Array, *, follows: int, mirrored: bool = False",
    ): {"False -> True": "the package always gives it"},
    ("model/plates.py", "x = np.linspace(a, b, 33)"): {"*": _TUNING},
    ("model/plates.py", "k = np.arange(1, plates.reach + 1)"): {"1 -> 2 #2": _OUT_OF_REACH},
    ("model/plates.py", "j = int(np.argmax((gap[:-1] > 0) != (gap[1:] > 0)))"): {
        "- -> nothing": "the first sign that differs from the one before is the first that differs from the first",
    },
    (
        "model/plates.py",
        'return [(int(i), int(n), int(j)) for i, n, j in found[np.argsort(found[:, 2], kind="stable")]]',
    ): {"2 -> 1": "the order in which candidates are solved; the earliest wins in any order"},
    ("model/section.py", "for n in range(1, 13, 2):"): {"13 -> (13 * 2 + 1)": _ROUNDING},
    ("model/joint.py", "slack = 1e-9"): {"*": _ROUNDING},
}
"""Changes that are no error: (file, line) -> {change, or "*" for all of the line: reason}."""
