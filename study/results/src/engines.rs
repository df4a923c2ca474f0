//! Names of the engines, in one place.

/// The engines by name, each with the title that people read, in the order of tables and legends.
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

/// The title of an engine; a name that is not known stands for itself.
pub fn engine_title(name: &str) -> &str {
    engine_rank(name).map_or(name, |rank| ENGINES[rank].1)
}

/// The place of an engine in [`ENGINES`].
pub fn engine_rank(name: &str) -> Option<usize> {
    ENGINES.iter().position(|engine| engine.0 == name)
}
