"""What the syntax tree does not give: errors written by hand, and which tests a file answers to."""

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
THICK = ("reference/test_thick.py", "properties/test_thickness.py")
CYCLES = ("unit/test_cycle.py", "properties/test_cycles.py")
VIBRATION = ("reference/test_dynamics.py", "properties/test_vibration.py", "unit/test_vibrate.py")
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
CELL = tuple(
    f"fe/test_cell.py::{test}"
    for test in (
        "test_the_work_of_the_torque_is_stored_or_rubbed_away",
        "test_the_scales_touch_where_and_as_they_should",
        "test_a_restart_file_that_cannot_be_written_is_one_line_before_any_work",
        "test_the_last_state_is_that_of_the_curve_and_reads_back",
    )
)
BEAM = tuple(
    f"fe/test_beam.py::{test}"
    for test in (
        "test_what_is_not_usable_is_refused",
        "test_free_memory_is_read",
        "test_a_beam_that_does_not_fit_is_refused",
        "test_tiles_join_where_the_cuts_are",
        "test_work_is_energy_and_friction",
        "test_the_fixed_end_takes_the_torque",
        "test_scales_touch_the_next_one",
        "test_the_local_twist_adds_up",
        "test_the_curve_in_si_units_with_restart",
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
            "test_indices_are_those_of_what_is_said_in_words",
            "test_points_do_not_depend_on_the_chunks",
        )
    ),
    "unit/test_uncertainty_cli.py::test_tolerances_that_cannot_be",
    "unit/test_uncertainty_cli.py::test_summary",
)
BENT = ("fe/test_exposed.py", "fe/test_cell_elastic.py")
CURVES = ("unit/test_compliant_twist.py", "unit/test_compliant_cycle.py")
COMPLIANT = ("properties/test_thick_scales.py", "reference/test_thick_curves.py", *CURVES)
CORNERS = ("unit/test_corner_contact.py", "unit/test_compliant_bent.py", "unit/test_compliant_bend_twist.py")
JACOBIAN = "unit/test_row_ends.py::test_derivatives_are_those_of_complex_steps"


def some(file: str, *names: str) -> tuple[str, ...]:
    """Name some tests of a file."""
    return tuple(f"{file}::test_{name}" for name in names)


CONTACTS = (
    *some("unit/test_contacts.py", "stiff_skin_by_a_torque_alone", "image_in_the_mirror", "free_strains_have_no_load"),
    *some("unit/test_contacts.py", "the_torque_is_the_slope_of_the_energy", "targets_that_go_back"),
    *some("unit/test_contacts.py", "what_happens_is_told", "work_that_a_snap_loses", "steps_do_not_matter"),
    *some("unit/test_contacts.py", "conditions_hold_where_events_are", "work_of_the_loads_there_and_back"),
    *some("unit/test_contacts.py", "a_contact_beside_another_one_comes_in_at_the_same_way_by_any_steps"),
    *some("unit/test_contacts.py", "lengths_times_ten", "engagement_is_where_boxes_meet"),
    "unit/test_work_there_and_back.py",
    "unit/test_contact_events.py",
    "unit/test_overlap.py",
    "reference/test_thick_curves.py",
    *some("unit/test_compliant_row.py", "virtual_work_without_friction", "energy_is_balanced", "where_a_row_ends"),
    *some("unit/test_compliant_row.py", "scales_that_repeat_for_ever_are_one_with_its_images"),
    *some("unit/test_compliant_row.py", "contacts_at_the_pressed_end_stick_and_the_last_scale_lies_down"),
    *some("unit/test_compliant_row.py", "a_joint_that_gives_in_one_motion_only_is_a_row_of_hinges"),
    *some("unit/test_compliant_row.py", "the_other_sense_is_the_mirror_image", "scales_slide_off_one_by_one"),
    "unit/test_cells.py",
    "unit/test_jumps.py",
    "unit/test_other_contacts.py",
    "unit/test_one_contact_solver.py",
    "unit/test_takeover.py",
    *some("properties/test_thick_scales.py", "energy_is_balanced_there_and_back", "friction_works_along_the_slip"),
    *some("properties/test_thick_scales.py", "stiffer_plates_become_rigid_and_thinner_ones_thin"),
    *some("properties/test_thick_scales.py", "a_corner_that_comes_in_beside_its_edges_contact_loses_no_work"),
    *some("properties/test_thick_scales.py", "force_and_moment_on_the_embedded_part", "steps_do_not_matter"),
    # without the test that meshes: the mesher's threads do not survive a fork, and a forked process waits for them
    *some("unit/test_tilt.py", "tilts_take_the_work_of_contacts", "contact_forces_near_the_ends_are_those_of_elements"),
    *some("unit/test_tilt.py", "scales_that_bear_alike_do_not_tilt", "a_roll_is_mirrored_with_the_beam"),
    *some("unit/test_compliant_twist.py", "the_stiffness_right_after_engagement", "twists_that_are_all_but_equal"),
    *some("unit/test_compliant_twist.py", "a_contact_that_leaves_its_edge_does_not_end_the_curve"),
    *some("unit/test_compliant_cycle.py", "a_stiff_joint_cycles_as_the_hinge", "the_loops_area_is_the_frictional_work"),
    *some("unit/test_compliant_cycle.py", "partial_loops_share_the_work", "without_friction_it_comes_back_as_it_went"),
    *some("unit/test_compliant_cycle.py", "soft_scales_come_back", "a_stiff_joint_drops_its_torque", "both_senses"),
    *some(
        "unit/test_compliant_bend_twist.py",
        "work_is_stored_or_rubbed_away",
        "the_work_turns_at_a_corner_without_contact",
    ),
    *some("unit/test_compliant_bend_twist.py", "bent_first_contacts_hand_over_and_nothing_jumps"),
    *some("unit/test_compliant_bend_twist.py", "more_contacts_come_in_on_the_way_and_are_told"),
    *some("properties/test_both_faces.py", "moment_and_torque_are_slopes_of_the_energy", "events_name_the_face"),
    *some("properties/test_both_faces.py", "a_cycle_goes_on_where_both_faces_touch"),
    "unit/test_contact_limits.py",
    "unit/test_corner_contact.py",
)
"""What the solver answers to, those that catch most first: some 15 s where it is compiled."""
SOLVER = (
    *("changes", "conditions", "detection", "equations", "follow", "handover", "locating", "newton"),
    *("slipped", "works", "written"),
)
RATES = ("geometry", "jacobian", "lifts", "linear", "meeting", "system", "touch", "vectors")
OWN_CELLS = (
    JACOBIAN,
    *some("unit/test_row_ends.py", "a_row_is_in_balance", "cells_that_are_held_alike_are_the_row_of_equal_cells"),
    *some("unit/test_row_ends.py", "energy_is_balanced_with_friction", "grips_that_keep_their_distance_pull"),
    *some("unit/test_row_ends.py", "energies_are_those_of_each_cell"),
    *some("unit/test_part.py", "it_is_in_balance", "work_is_balanced_there_and_back", "grips_are_those_of_the_row"),
    *some("unit/test_part.py", "a_clamped_bar_is_the_elastica", "the_root_bears_force_and_moment"),
    *some("unit/test_part.py", "a_bar_that_bows_as_it_twists_is_a_rod_under_one_couple", "weight_is_a_force_over_all"),
    *some("unit/test_part.py", "end_moment_is_the_row_under_a_couple", "two_rollers_are_two_cantilevers"),
)
BOTH_FACES = (
    *some("unit/test_rows_of_both_faces.py", "a_cell_far_from_free_ends_is_one_of_the_endless_beam"),
    *some("unit/test_rows_of_both_faces.py", "mirrored_faces_answer_a_force_up_as_one_down"),
    *some("unit/test_rows_of_both_faces.py", "turned_faces_keep_the_axis_straight_however_the_ends_are_held"),
    *some("unit/test_rows_of_both_faces.py", "every_door_gives_one_answer"),
)
TESTS: dict[str, tuple[str, ...]] = {
    "model/twisting.py": ("unit/test_twisting_kernel.py", *REFERENCE, *THICK),
    "model/laws.py": ("unit/test_laws.py", "unit/test_twisting_kernel.py", *REFERENCE),
    "model/mechanics.py": (
        "unit/test_laws.py",
        "unit/test_bending.py",
        *REFERENCE,
        "unit/test_ends.py",
        *PROPERTIES[:2],
    ),
    "model/bending.py": ("unit/test_bending.py", "unit/test_bend_oblique.py", "unit/test_response.py"),
    "model/paths.py": (
        *REFERENCE,
        *THICK,
        "unit/test_ends.py",
        *WORK,
        "unit/test_bending.py",
        "unit/test_api.py",
        *PROPERTIES[:4],
    ),
    "model/energy.py": ("unit/test_energy.py", REFERENCE[1], "unit/test_response.py", PROPERTIES[4]),
    "model/neighbours.py": (*REFERENCE, *THICK, "unit/test_ends.py", PROPERTIES[4], *PROPERTIES[:3]),
    "model/bracket.py": ("unit/test_bracket.py", "unit/test_ends.py"),
    "model/evaluation.py": (*REFERENCE, *THICK, "unit/test_ends.py", "unit/test_bending.py", PROPERTIES[4]),
    "model/follow.py": (
        *REFERENCE,
        *THICK,
        "unit/test_ends.py",
        "unit/test_bending.py",
        PROPERTIES[4],
        "properties/test_campaign.py",
        *PROPERTIES[:3],
    ),
    "model/crossings.py": ("unit/test_ends.py", *THICK, PROPERTIES[4], "properties/test_campaign.py", *REFERENCE),
    "model/figures.py": (
        REFERENCE[1],
        "unit/test_energy.py",
        "unit/test_solve.py",
        PROPERTIES[4],
        "unit/test_batch.py",
    ),
    "model/plates.py": ("unit/test_plates.py", THICK[1], REFERENCE[1], "unit/test_ends.py", PROPERTIES[2]),
    "model/boxes.py": ("unit/test_boxes.py", "unit/test_plates.py", THICK[1]),
    "model/history.py": ("unit/test_history.py", "unit/test_cycle.py", "properties/test_cycles.py"),
    "model/elastic_plate.py": (COMPLIANT[0], BENT[0], COMPLIANT[1]),
    "model/sensitivity.py": ("unit/test_inverse_figures.py", "unit/test_gradient.py"),
    "model/tracks.py": (
        "unit/test_bracket.py",
        "unit/test_inverse_figures.py",
        "unit/test_response.py",
        "unit/test_gradient.py",
    ),
    "model/section.py": ("unit/test_section_joint.py",),
    "model/joint.py": ("unit/test_section_joint.py", PROPERTIES[5], "unit/test_design.py"),
    "loads.py": ("unit/test_loads.py", "unit/test_follow.py", "unit/test_solve.py", "unit/test_response.py"),
    "units.py": ("unit/test_units.py", "unit/test_flags.py", "unit/test_measured.py", "unit/test_web_state.py"),
    "errors.py": ("unit/test_errors.py", "unit/test_flags.py", "unit/test_beamfile_errors.py"),
    "arguments.py": (
        THICK[1],
        "unit/test_api.py",
        "unit/test_solve.py",
        "unit/test_gradient.py",
        "unit/test_response.py",
    ),
    "arrays/edge_contacts.py": (THICK[0], PROPERTIES[2], "unit/test_api.py", REFERENCE[1]),
    "arrays/derivatives.py": ("unit/test_gradient.py",),
    "arrays/designs_table.py": ("unit/test_designs_table.py",),
    "batch/__init__.py": ("unit/test_solve.py", "unit/test_ends.py", PROPERTIES[4], "unit/test_api.py"),
    "batch/answers.py": ("unit/test_solve.py", *BATCH),
    "arrays/solution.py": (
        REFERENCE[1],
        *THICK,
        "unit/test_ends.py",
        "unit/test_solve.py",
        "unit/test_gradient.py",
        PROPERTIES[4],
    ),
    "beam/faces.py": ("properties/test_both_faces.py",),
    "curves/both_faces.py": ("properties/test_both_faces.py",),
    "beam/joint_law.py": ("unit/test_joint_law.py", "unit/test_columns.py", "unit/test_design.py"),
    "beam/parts.py": (
        "unit/test_design.py",
        "unit/test_material.py",
        "unit/test_beamfile_errors.py",
        "unit/test_matrixfile.py",
    ),
    "beam/design.py": ("unit/test_design.py", "unit/test_joint_law.py", "unit/test_response.py"),
    "beam/mass.py": ("unit/test_mass.py",),
    "beam/matrixfile.py": ("unit/test_matrixfile.py", "fe/test_joint_file.py"),
    "beam/validity.py": ("unit/test_design.py", "unit/test_material.py", PROPERTIES[5], "unit/test_response.py"),
    "joints/factor.py": ("unit/joints/test_law.py", "unit/joints/test_choice.py"),
    "joints/law.py": ("unit/joints/test_law.py",),
    "joints/processes.py": ("unit/joints/test_law.py",),
    "fe/pitch_stiffness.py": ("fe/test_pitch_stiffness.py", "fe/test_long_tabs.py"),
    "joints/choice.py": ("unit/joints/test_choice.py",),
    "joints/tilt.py": ("unit/test_tilt.py",),
    "curves/way.py": ("unit/test_follow.py", "unit/test_response.py", *CYCLES, *CURVES),
    "curves/curve_figures.py": ("unit/test_response.py", *CYCLES, *CURVES),
    "curves/given.py": ("unit/test_cycle.py", "unit/test_bend_twist.py"),
    "curves/histories.py": CYCLES,
    "curves/hinge.py": ("unit/test_response.py", THICK[1], "unit/test_energy.py", "unit/test_follow.py"),
    "curves/hinge_cycles.py": CYCLES,
    "curves/chosen.py": ("unit/test_follow.py", "unit/test_bend_doors.py", "unit/test_bend_twist.py"),
    "curves/compliant.py": CURVES,
    "curves/compliant_figures.py": CURVES,
    "curves/compliant_walk.py": (*CURVES, "unit/test_bend_compliant.py", "unit/test_compliant_bend_twist.py"),
    "curves/compliant_polygons.py": ("unit/test_compliant_bend_twist.py", "unit/test_own_scales_bent_twisted.py"),
    "curves/compliant_cycles.py": ("unit/test_compliant_cycle.py", "unit/test_bend_cycle.py"),
    **{f"contacts/{name}.py": CONTACTS for name in SOLVER},
    **{f"contacts/{name}.py": ("unit/test_contact_linear.py", JACOBIAN, *CONTACTS) for name in RATES},
    "contacts/supports.py": OWN_CELLS,
    "contacts/ties.py": OWN_CELLS,
    "contacts/derivatives.py": ("unit/test_contact_derivatives.py",),
    "contacts/events.py": (
        "unit/test_jumps.py",
        "unit/test_contacts.py::test_what_happens_is_told",
        "unit/test_plane.py",
        *CORNERS,
    ),
    **{f"contacts/{name}.py": (*CONTACTS, "unit/test_contact_derivatives.py") for name in ("entry", "increments")},
    "contacts/moved.py": ("unit/test_contact_derivatives.py",),
    "contacts/onward.py": ("unit/test_section_law.py",),
    "contacts/snapshot.py": ("unit/test_section_law.py",),
    "contacts/of_face.py": ("properties/test_both_faces.py", *BOTH_FACES),
    "contacts/from_endless.py": ("unit/test_finite_ratio.py", *BOTH_FACES),
    "contacts/own_scales.py": ("unit/test_finite_ratio.py", *BOTH_FACES),
    "contacts/relaxing.py": ("unit/test_contact_limits.py",),
    "contacts/path.py": (*COMPLIANT, "unit/test_compliant_beams.py"),
    "contacts/row.py": (
        *some("unit/test_compliant_row.py", "virtual_work_without_friction", "energy_is_balanced", "where_a_row_ends"),
        *some("unit/test_compliant_row.py", "the_effect_of_an_end_decays_as_said", "scales_slide_off_one_by_one"),
        *("unit/test_contact_limits.py", "unit/test_row_ends.py", "unit/test_row.py", *OWN_CELLS, *BOTH_FACES),
    ),
    "contacts/states.py": COMPLIANT,
    "curves/hinge_polygons.py": ("unit/test_bend_twist.py", "unit/test_screw_path.py"),
    "curves/labelled.py": (
        "unit/test_follow.py",
        "unit/test_response.py",
        "unit/test_cycle.py",
        "unit/test_cli_summary.py",
        "unit/test_store.py",
    ),
    "curves/finite_rows.py": ("unit/test_row.py", "unit/test_compliant_row.py", "unit/test_fit_checks.py"),
    "curves/hinge_rows.py": ("unit/test_row.py",),
    "curves/rows.py": ("unit/test_compliant_row.py", "unit/test_own_scales.py"),
    "curves/doors.py": (
        "unit/test_api.py",
        "unit/test_response.py",
        "unit/test_follow.py",
        PROPERTIES[3],
        "unit/test_cli_summary.py",
    ),
    "dynamics/joint_branches.py": ("unit/test_vibrate_bent.py", *VIBRATION),
    "dynamics/branches.py": VIBRATION,
    "dynamics/hinge_branches.py": VIBRATION,
    "dynamics/modes.py": VIBRATION,
    "dynamics/decay.py": VIBRATION,
    "dynamics/motion.py": VIBRATION,
    "dynamics/doors.py": VIBRATION,
    "dynamics/systems.py": (*VIBRATION, "unit/test_vibrate_bent.py", "unit/test_mass.py"),
    "dynamics/ratios.py": VIBRATION,
    "fe/walk.py": ("fe/test_matrix.py", "fe/test_snap.py", *CELL, BENT[1]),
    "fe/body.py": ("fe/test_body.py", "fe/test_hinged.py", *CELL, *BEAM, BENT[1]),
    "fe/contact.py": ("fe/test_contact.py", "fe/test_row_contact.py", "fe/test_hinged.py"),
    "fe/solver.py": ("fe/test_solver.py", "fe/test_body.py"),
    "fe/assembly.py": ("fe/test_hinged.py", *CELL, *BEAM, BENT[1]),
    "fe/periodic.py": ("fe/test_bent.py",),
    "fe/plate.py": ("fe/test_plate.py", "fe/test_row_contact.py", "fe/test_matrix.py"),
    "fe/rows.py": ("fe/test_plate.py", "fe/test_row_contact.py", "fe/test_matrix.py"),
    "fe/runs.py": ("fe/test_snap.py", "fe/test_cell_input.py", *CELL, *BEAM),
    "fe/sizes.py": ("fe/test_cell_input.py", *CELL),
    "fe/stiffness.py": ("fe/test_joint.py", "fe/test_joint_file.py"),
    "fe/agreement.py": ("unit/test_compare.py", "fe/test_verify.py"),
    "fe/balance.py": ("fe/test_balance.py", "fe/test_matrix.py", "fe/test_hinged.py"),
    "fe/exposed.py": BENT,
    "fe/bending.py": BENT,
    "fe/elements.py": ("fe/test_elements.py", "fe/test_body.py"),
    "study/plan.py": ("unit/test_sweep.py", "unit/test_map_cli.py"),
    "study/slices.py": ("unit/test_sweep.py", "unit/test_map_cli.py"),
    "study/columns.py": ("unit/test_columns.py", "unit/test_joint_law.py", "unit/test_sweep.py"),
    "study/hinge_columns.py": ("unit/test_columns.py", "unit/test_sweep_held.py", "unit/test_sweep.py"),
    "study/parameters.py": ("unit/test_sweep.py", "unit/test_map_cli.py", "unit/test_columns.py"),
    "study/store.py": ("unit/test_sweep.py", "unit/test_sweep_damage.py", "unit/test_sweep_resume.py"),
    "study/chunks.py": ("unit/test_sweep_damage.py",),
    "study/tolerances/distributions.py": UNCERTAIN,
    "study/tolerances/monte_carlo.py": (*UNCERTAIN, "unit/test_own_scales.py"),
    "study/tolerances/statistics.py": UNCERTAIN,
    "identify/hinge_points.py": ("unit/test_fit_branches.py", "unit/test_fit.py"),
    "identify/joint_points.py": (
        "unit/test_fit_recovery.py",
        "unit/test_fit_branches.py",
        "fe/test_fit_compliant.py",
        "unit/test_fit_doubts.py",
        "unit/test_fit_parts.py",
    ),
    "identify/readings.py": ("unit/test_fit_branches.py", "unit/test_fit_doubts.py"),
    "identify/noise.py": ("unit/test_fit_doubts.py", "unit/test_fit_checks.py"),
    "identify/slope.py": ("unit/test_fit_checks.py",),
    "identify/selection.py": ("unit/test_fit_doubts.py", "unit/test_fit.py"),
    "identify/remarks.py": ("unit/test_fit_doubts.py", "unit/test_fit_checks.py"),
    "identify/prepare.py": ("unit/test_fit.py", "unit/test_fit_input.py", "fe/test_fit_compliant.py"),
    "identify/posterior.py": ("unit/test_fit_input.py", "unit/test_fit_parts.py", "unit/test_fit_known.py"),
    "identify/fitting.py": ("unit/test_fit.py", "unit/test_fit_input.py", "unit/test_fit_doubts.py"),
    "identify/estimate.py": ("unit/test_fit_branches.py", "unit/test_fit.py"),
    "identify/decay_fit.py": ("unit/test_fit_decay.py",),
    "identify/records.py": (
        "unit/test_fit_branches.py",
        "unit/test_fit_input.py",
        "unit/test_fit.py",
        "unit/test_fit_decay.py",
    ),
    "inverse/hinge_figures.py": INVERSE,
    "inverse/named_figures.py": INVERSE,
    "inverse/residuals.py": INVERSE,
    "inverse/goals.py": (*INVERSE, "unit/test_inverse.py::test_a_curve_and_a_tangent"),
    "inverse/limits.py": INVERSE,
    "inverse/space.py": ("unit/test_joint_law.py", *INVERSE),
    "inverse/front.py": (
        "unit/test_inverse_front.py::test_domination_and_spreading_by_hand",
        "unit/test_inverse_front.py::test_costs_fall_where_objectives_get_better",
        "unit/test_inverse_front.py::test_settings_are_whole_numbers",
        "unit/test_inverse_front.py::test_the_front_of_a_grid_in_two_dimensions",
        "unit/test_inverse_front.py::test_no_point_dominates_another_and_each_is_what_it_says",
    ),
    "io/measured.py": ("unit/test_measured.py", "unit/test_fit_input.py"),
    "io/tabular.py": ("unit/test_measured.py", "unit/test_designs_table.py", "unit/test_store.py"),
    "fabrication/mesh.py": ("unit/test_export_solids.py", "unit/test_export.py"),
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
    # the travel of a part in pitches; samples without priors, or all with one weight
    ("identify/joint_points.py", "x[1:] / (course.share * beam.pitch)", "x[1:] / course.share"),
    ("identify/posterior.py", "known = -0.5 * np.sum", "known = 0 * np.sum"),
    ("identify/posterior.py", "weights = np.exp(ratio - ratio.max())", "weights = np.exp(0 * ratio)"),
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
        "(pt.load_rate, f.D, tip, side, pt.turn))",
        "(abs(pt.load_rate) + 1, f.D, tip, side, pt.turn))",
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
    ("model/follow.py", "\nMARGINS = (KINEMATIC, FRICTIONAL,", "\nMARGINS = (FRICTIONAL, KINEMATIC,"),
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
