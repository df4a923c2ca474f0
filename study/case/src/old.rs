//! Cases of format 1: which of their keys are what in format 2.

use std::collections::BTreeSet;

use toml::{Table, Value};

/// Old keys, and what they are now. A `*` stands for any key.
const CHANGES: &[(&str, &str)] = &[
    (
        "kind",
        "left out: the box, the walls and the engines say it",
    ),
    ("gas.disks", "gas.number"),
    ("gas.packing_fraction", "box.packing_fraction"),
    ("gas.species", "[[species]] with share, beside gas.number"),
    ("contact.restitution", "gas.restitution"),
    (
        "contact.tangential_restitution",
        "gas.tangential_restitution",
    ),
    ("contact.inertia", "gas.inertia"),
    (
        "box.boundary",
        "left out: faces are periodic unless [walls] says otherwise",
    ),
    ("species.count", "species.number"),
    ("species.density", "species.number_density"),
    ("power_law.temperature", "gas.temperature"),
    ("continuous.particles", "continuous.number"),
    ("continuous.temperature", "gas.temperature"),
    ("heating.interval", "thermostat.interval"),
    ("start.temperature", "gas.temperature"),
    ("start.mean_free_path", "gas.mean_free_path"),
    ("start.collisions_per_particle", "start.equilibration"),
    (
        "start.most_collisions_per_particle",
        "start.longest_equilibration",
    ),
    ("run.blocks", "measure.fields.blocks"),
    ("fields.cells", "measure.fields.cells"),
    ("fields.windows", "measure.fields.windows"),
    (
        "engine.selection",
        "engine.dsmc-homogeneous.selection, where \"own\" is \"alias-tables\" and \"bird\" is \"single-majorant\"",
    ),
    (
        "engine.dsmc.scheme",
        "the name of the table: scheme = \"x\" is [engine.dsmc-x]",
    ),
    (
        "engine.dsmc",
        "[engine.dsmc-boltzmann], or the scheme that it names",
    ),
    (
        "engine.*.simulators_per_disk",
        "simulators_per_particle in the same table",
    ),
    (
        "engine.*.simulators_per_grain",
        "simulators_per_particle in the same table",
    ),
    (
        "engine.*.cell_size",
        "a length in units of the case, no longer in diameters",
    ),
    (
        "engine.*.partner_radius",
        "a length in units of the case, no longer in diameters",
    ),
    (
        "measure.impact_windows",
        "measure.impact_parameters.windows",
    ),
    ("measure.impact_bins", "measure.impact_parameters.bins"),
    (
        "measure.structure_times",
        "measure.structure_factor.times and measure.pair_correlation.times",
    ),
    (
        "measure.structure_assignment",
        "measure.structure_factor.assignment",
    ),
    (
        "measure.structure_correction",
        "measure.structure_factor.correction",
    ),
    (
        "measure.largest_wave_number",
        "measure.structure_factor.largest_wave_number",
    ),
    (
        "measure.pair_correlation_range",
        "measure.pair_correlation.range",
    ),
    ("measure.snapshot_times", "measure.snapshots.times"),
    (
        "measure.mean_squared_displacement",
        "the table [measure.displacement]",
    ),
    ("measure.displacement_start", "measure.displacement.from"),
    ("measure.displacement", "the table [measure.displacement]"),
    (
        "measure.velocity_correlation",
        "the table [measure.velocity_correlation]",
    ),
    (
        "measure.paths",
        "measure.time_averaged_displacement.particles",
    ),
    ("measure.size_distribution_times", "measure.clusters.times"),
    ("measure.steady_from", "measure.clusters.steady_from"),
    ("measure.fit_monomers", "measure.clusters.fit_monomers"),
];

/// Lists the changes that a case of format 1 needs, as `old -> new`.
pub(crate) fn changes(table: &Table) -> Vec<String> {
    let mut keys = BTreeSet::new();
    gather(table, "", &mut keys);
    let kind = table.get("kind").and_then(Value::as_str);
    let mut changes = Vec::new();
    for (old, new) in CHANGES {
        let length = *old == "engine.*.cell_size" || *old == "engine.*.partner_radius";
        if kind == Some("flow") && length {
            continue;
        }
        for key in keys.iter().filter(|key| matches(old, key)) {
            changes.push(format!("{key} -> {new}"));
        }
    }
    let sides = table.get("box").and_then(|domain| domain.get("size"));
    let spheres = kind == Some("homogeneous") && !keys.contains("gas.dimension")
        || sides
            .and_then(Value::as_array)
            .is_some_and(|size| size.len() == 3);
    if spheres {
        changes.push("spheres -> gas.dimension = 3".to_owned());
    }
    changes
}

/// Collects all dotted keys, without the numbers of blocks; keys that a sweep names are among them.
fn gather(table: &Table, path: &str, keys: &mut BTreeSet<String>) {
    for (key, value) in table {
        let inside = |value: &Value| value.as_table().cloned();
        if path.is_empty() && key == "sweep" {
            let blocks = value.as_array().into_iter().flatten().filter_map(inside);
            keys.extend(blocks.flat_map(|block| block.into_iter().map(|(key, _)| key)));
            continue;
        }
        let path = if path.is_empty() {
            key.clone()
        } else {
            format!("{path}.{key}")
        };
        match value {
            Value::Table(table) => gather(table, &path, keys),
            Value::Array(list) => {
                let tables = list.iter().filter_map(Value::as_table);
                tables.for_each(|table| gather(table, &path, keys));
            }
            _ => {}
        }
        keys.insert(path);
    }
}

fn matches(pattern: &str, key: &str) -> bool {
    let (mut pattern, mut key) = (pattern.split('.'), key.split('.'));
    loop {
        match (pattern.next(), key.next()) {
            (None, None) => return true,
            (Some(wanted), Some(found)) if wanted == "*" || wanted == found => {}
            _ => return false,
        }
    }
}
