//! Checks of engines: which gases they fit, and which keys they have.

use super::{Checked, Relations};
use crate::format::{Copies, FACES, Face, FaceWord, MonteCarlo, Neighbourhood, Weights};

/// Keys of all Monte Carlo schemes.
const ALL: &[&str] = &["simulators_per_particle", "wall_contact"];

/// Keys of schemes with partners within a cell.
const WITHIN: &[&str] = &[
    "cell_size",
    "steps_per_cell_crossing",
    "displacement",
    "weights",
];

/// Keys of each scheme besides those, and whether its partners lie across cells.
const SCHEMES: [(&str, &[&str], bool); 6] = [
    ("dsmc-boltzmann", &[], false),
    ("dsmc-free-volume", &["max_contact_value"], false),
    (
        "dsmc-enskog",
        &["max_contact_value", "density_window"],
        false,
    ),
    (
        "dsmc-esmc",
        &[
            "cell_size",
            "steps_per_mean_free_time",
            "max_contact_value",
            "density_window",
        ],
        true,
    ),
    (
        "dsmc-stochastic-disks",
        &["steps_per_mean_free_time", "stiffness"],
        true,
    ),
    (
        "dsmc-contact-point",
        &[
            "cell_size",
            "steps_per_mean_free_time",
            "max_contact_value",
            "partner_radius",
            "simulator_start",
        ],
        true,
    ),
];

impl Relations<'_> {
    pub(super) fn engines(&self) -> Checked {
        let case = self.case;
        let engine = &case.engine;
        let schemes: [&Option<MonteCarlo>; 6] = [
            &engine.boltzmann,
            &engine.free_volume,
            &engine.enskog,
            &engine.esmc,
            &engine.stochastic_disks,
            &engine.contact_point,
        ];
        let monte_carlo = schemes.iter().filter(|scheme| scheme.is_some()).count();
        if !case.has_box() {
            let allowed = "this engine needs a [box]; without one it is dsmc-homogeneous";
            self.without(&["engine.ed"], allowed)?;
            for (name, _, _) in SCHEMES {
                self.without(&[&format!("engine.{name}")], allowed)?;
            }
            return Ok(());
        }
        self.without(
            &["engine.dsmc-homogeneous"],
            "this engine is for gases without a [box]",
        )?;
        let names: Vec<&str> = SCHEMES.iter().map(|scheme| scheme.0).collect();
        self.ensure(
            monte_carlo > 0 || engine.ed.is_some(),
            "engine",
            format!(
                "at least one engine, such as [engine.ed]: ed, {}",
                names.join(", ")
            ),
        )?;
        let alone = engine.ed.is_none() && monte_carlo == 1 && engine.boltzmann.is_some();
        self.ensure(
            case.gas.mean_free_path.is_none() || alone,
            "gas.mean_free_path",
            "a mean free path is given where [engine.dsmc-boltzmann] runs alone",
        )?;
        if engine.ed.is_some() {
            let disks = "exact dynamics is of disks: gas.dimension = 2";
            self.ensure(self.dimension() == 2, "engine.ed", disks)?;
            for (axis, side) in (0..6).map(|face| (face / 2, face % 2)) {
                self.ensure(
                    *case.walls.at(axis, side) != Face::Word(FaceWord::Open),
                    format!("walls.{}", FACES[axis][side]),
                    "exact dynamics keeps its disks: no open face beside [engine.ed]",
                )?;
            }
        }
        self.ensure(
            case.accuracy.is_none() || monte_carlo > 0,
            "accuracy",
            "an accuracy is that of Monte Carlo engines: at least one",
        )?;
        for ((name, keys, across), scheme) in SCHEMES.into_iter().zip(schemes) {
            if let Some(scheme) = scheme {
                self.scheme(name, keys, across, scheme)?;
            }
        }
        if let Some(accuracy) = &case.accuracy {
            self.ensure(
                accuracy.share().is_some(),
                "accuracy.target",
                "a share in quotes, such as \"1%\" or \"0.01\", above 0 and below 1",
            )?;
        }
        Ok(())
    }

    fn scheme(&self, name: &str, own: &[&str], across: bool, scheme: &MonteCarlo) -> Checked {
        let case = self.case;
        let shared: &[&str] = if across { &[] } else { WITHIN };
        let known: Vec<&str> = [ALL, shared, own].concat();
        let table = self.table["engine"][name].as_table();
        for key in table.into_iter().flat_map(|table| table.keys()) {
            let allowed = format!(
                "{name} does not have this key; its keys are {}",
                known.join(", ")
            );
            self.ensure(
                known.contains(&key.as_str()),
                format!("engine.{name}.{key}"),
                allowed,
            )?;
        }
        let free = case.obstacle.is_empty();
        self.ensure(
            free || !across,
            format!("engine.{name}"),
            "obstacles go with dsmc-boltzmann, dsmc-free-volume, dsmc-enskog and ed",
        )?;
        let is_mean = matches!(scheme.density_window, Some(Neighbourhood::Whole(_)));
        self.ensure(
            free || !is_mean,
            format!("engine.{name}.density_window"),
            "a number of cells, whose density ends at obstacles; the mean of the whole box does not",
        )?;
        let disks = name != "dsmc-stochastic-disks" || self.dimension() == 2;
        let allowed = "stochastic disks are disks: gas.dimension = 2";
        self.ensure(disks, format!("engine.{name}"), allowed)?;
        let coherent = scheme.simulator_start == Some(Copies::Coherent);
        let movable = case.is_uniform() && !case.is_rough() && case.start.region.is_none();
        self.ensure(
            movable || !coherent,
            format!("engine.{name}.simulator_start"),
            "\"independent\": \"coherent\" copies of the start are moved and turned, in a uniform gas of smooth particles; next to \
             walls and obstacles, in gravity, in a region and of particles that spin, each set of simulators is a start of its own",
        )?;
        let kicked = case.bath().is_some() && scheme.weights.is_some();
        self.ensure(
            !kicked,
            format!("engine.{name}.weights"),
            "simulators of equal weight beside random kicks of [thermostat], which conserve the momentum of all particles together",
        )?;
        let one = |all: &Weights| all.factors.is_some() != all.adaptive_stripes.is_some();
        self.ensure(
            scheme.weights.as_ref().is_none_or(one),
            format!("engine.{name}.weights"),
            "weights have either factors, or a number of stripes whose factors follow the number of simulators",
        )?;
        let bounded = !case.walls.is_periodic() || !free;
        self.ensure(
            bounded || scheme.wall_contact.is_none(),
            format!("engine.{name}.wall_contact"),
            "this key needs walls or obstacles",
        )
    }
}
