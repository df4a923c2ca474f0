//! Renamed keys of the case format: an error for an old key names the new one.

/// Old keys of the case format with their new names. `*` stands for the name of any table.
const RENAMED: &[(&str, &str)] = &[
    ("continuous", "polydisperse"),
    ("engine.*.copies", "simulator_start"),
    ("engine.*.largest_contact_value", "max_contact_value"),
    ("engine.*.neighbourhood", "density_window"),
    ("engine.*.steps_per_crossing", "steps_per_cell_crossing"),
    ("engine.*.walls_act_on", "wall_contact"),
    ("engine.*.weights.stripes", "adaptive_stripes"),
    ("box.critical_lengths", "width_over_critical_length"),
    (
        "gas.contact_values",
        "pair_correlation, \"boltzmann\" or \"enskog\"",
    ),
    ("gas.inertia", "reduced_inertia"),
    ("obstacle.*.disc", "circle"),
    ("sticking", "aggregation"),
    ("verdict.false_alarm", "family_wise_error_rate"),
];

/// Returns the new name of a renamed key; `None` if the key was not renamed.
pub(crate) fn new_name(key: &[String]) -> Option<&'static str> {
    let fits = |old: &str| {
        let parts = old.split('.');
        parts.clone().count() == key.len()
            && parts
                .zip(key)
                .all(|(part, found)| part == "*" || part == found)
    };
    let (_, new) = RENAMED.iter().find(|(old, _)| fits(old))?;
    Some(new)
}
