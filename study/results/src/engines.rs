//! Names and titles of the engines, and the order in which tables and legends have them.

/// Names of all engines with their titles, in the order of tables and legends.
pub const ENGINES: [(&str, &str); 8] = [
    ("ed", "ED (exact)"),
    ("dsmc-boltzmann", "DSMC Boltzmann"),
    ("dsmc-free-volume", "DSMC free volume"),
    ("dsmc-enskog", "DSMC Enskog"),
    ("dsmc-esmc", "ESMC"),
    ("dsmc-stochastic-disks", "DSMC stochastic disks"),
    ("dsmc-contact-point", "DSMC contact point"),
    ("dsmc-homogeneous", "DSMC without positions"),
];

/// Returns the title of an engine; an unknown name is its own title.
pub fn engine_title(name: &str) -> &str {
    engine_rank(name).map_or(name, |rank| ENGINES[rank].1)
}

/// Returns the position of an engine in [`ENGINES`]; `None` for an unknown name.
pub fn engine_rank(name: &str) -> Option<usize> {
    ENGINES.iter().position(|engine| engine.0 == name)
}

/// Returns the title of a derived quantity. That of one engine begins with the title of the engine.
pub fn quantity_title(name: &str) -> String {
    let of_engine = |(engine, title): &(&str, &str)| {
        let rest = name.strip_prefix(&engine.replace('-', "_"))?;
        Some(format!("{title}: {}", rest.strip_prefix('_')?))
    };
    let title = ENGINES.iter().find_map(of_engine);
    let title = title.unwrap_or(name.to_owned()).replace('_', " ");
    // The name of a person is capitalised.
    title.replace("haff", "Haff")
}

#[cfg(test)]
mod tests {
    use super::quantity_title;

    #[test]
    fn quantities_of_engines_have_their_titles() {
        for (name, title) in [
            ("mean_free_path", "mean free path"),
            ("ed_cells", "ED (exact): cells"),
            ("edge_length", "edge length"),
            ("haff_time", "Haff time"),
            (
                "dsmc_contact_point_cell_size",
                "DSMC contact point: cell size",
            ),
        ] {
            assert_eq!(quantity_title(name), title);
        }
    }
}
