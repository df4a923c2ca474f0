//! Checks of the engines of a case: which gases each is for, and which keys its table has.

use super::{Checked, Relations};
use crate::format::{
    DensityWindowSpec, FACES, FaceSpec, FaceWord, MonteCarloSpec, SCHEMES, SchemeFormat,
    SimulatorStartSpec, WeightsSpec,
};

impl Relations<'_> {
    pub(super) fn engines(&self) -> Checked {
        let case = self.case;
        let engine = &case.engine;
        let schemes = || {
            SCHEMES
                .iter()
                .map(|scheme| (scheme, (scheme.table)(engine)))
        };
        let monte_carlo = schemes().filter(|(_, written)| written.is_some()).count();
        if !case.has_box() {
            let allowed = "this engine needs a [box]; without one it is dsmc-homogeneous";
            self.without(&["engine.ed"], allowed)?;
            for scheme in &SCHEMES {
                self.without(&[&format!("engine.{}", scheme.engine)], allowed)?;
            }
            return Ok(());
        }
        self.without(
            &["engine.dsmc-homogeneous"],
            "this engine is for gases without a [box]",
        )?;
        let names: Vec<&str> = SCHEMES.iter().map(|scheme| scheme.engine).collect();
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
                    *case.walls.face_at(axis, side) != FaceSpec::Word(FaceWord::Open),
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
        for (scheme, written) in schemes() {
            if let Some(written) = written {
                self.scheme(scheme, written)?;
            }
        }
        if let Some(accuracy) = &case.accuracy {
            self.ensure(
                accuracy.parse_share().is_some(),
                "accuracy.target",
                "a share in quotes, such as \"1%\" or \"0.01\", above 0 and below 1",
            )?;
        }
        Ok(())
    }

    fn scheme(&self, format: &SchemeFormat, scheme: &MonteCarloSpec) -> Checked {
        let case = self.case;
        let (name, keys) = (format.engine, format.keys());
        let table = self.table["engine"][name].as_table();
        for key in table.into_iter().flat_map(|table| table.keys()) {
            let allowed = format!(
                "{name} does not have this key; its keys are {}",
                keys.join(", ")
            );
            self.ensure(
                keys.contains(&key.as_str()),
                format!("engine.{name}.{key}"),
                allowed,
            )?;
        }
        let free = case.obstacle.is_empty();
        self.ensure(
            free || !format.is_cross_cell,
            format!("engine.{name}"),
            format!("obstacles go with {} and ed", within_cell().join(", ")),
        )?;
        let is_mean = matches!(scheme.density_window, Some(DensityWindowSpec::Whole(_)));
        self.ensure(
            free || !is_mean,
            format!("engine.{name}.density_window"),
            "a number of cells, whose density ends at obstacles; the mean of the whole box does not",
        )?;
        let disks = !format.is_planar || self.dimension() == 2;
        let allowed = "stochastic disks are disks: gas.dimension = 2";
        self.ensure(disks, format!("engine.{name}"), allowed)?;
        let coherent = scheme.simulator_start == Some(SimulatorStartSpec::Coherent);
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
        let one = |all: &WeightsSpec| all.factors.is_some() != all.adaptive_stripes.is_some();
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

/// Returns the names of the Monte Carlo engines that select partners within a cell.
pub(super) fn within_cell() -> Vec<&'static str> {
    let within = SCHEMES.iter().filter(|scheme| !scheme.is_cross_cell);
    within.map(|scheme| scheme.engine).collect()
}
