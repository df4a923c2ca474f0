//! Whole runs against theory: driven gases, mixtures with and without positions, sticking.

use std::fs;

use crate::support::program::{
    CHANNEL, CLUSTERS, Columns, DRIVEN_MIXTURE, MIXTURE, TestFolder, bundled, manifest, plan,
};
use stosszahl::model::Constant;
use stosszahl::theory::{Component, ContactValues, MaxwellianMixture};

/// Both engines settle at the temperature of Enskog's theory, in the second half of the run.
///
/// The theory is approximate in three respects, for which 1.1 % is allowed:
///
/// - The contact value is right to 0.1 %.
/// - N is in place of N - 1, and the mean of T^(3/2) in place of its power: together below 2/N =
///   0.5 %.
/// - The noise stirs up a flow, as it conserves momentum only in the whole box (van Noije, Ernst,
///   Trizac & Pagonabarraga, Phys. Rev. E 59, 4326 (1999)). A transverse mode of wave number k
///   holds the share 1/(nu k^2 t0) more than T/2 at T = T(0), with the viscosity
///   nu = 1/(2 sqrt(pi) n) = 4.4: 0.41 for the longest, and 4 in the sum over all modes, of 800
///   degrees of freedom. That is 0.5 % (ED; in DSMC less, by the simulators per disk).
///
/// The statistical tolerance is the measured standard error times 5.41, Student's t with seven
/// degrees of freedom at a false alarm of 1e-3. More than 3 % in all fails too, because a heating
/// that is wrong by 5 % would pass. A quarter of the run is 30 times the relaxation time 1/(3
/// sqrt(T)), so the means of two quarters are independent but for 1/30, and 2 % more in the error
/// of both.
#[test]
fn both_engines_settle_at_the_temperature_of_theory() {
    let work = TestFolder::new(&fs::read_to_string(bundled("driven")).expect("a case"));
    work.done("run case.toml --out out");
    let table = Columns::read(&work.path("out"), "steady_state");
    let column = |name| table.numbers(name);
    let (found, errors) = (column("temperature_ratio"), column("temperature_ratio_se"));
    let theory = column("temperature_ratio_theory");
    assert!(column("replicas").iter().all(|&replicas| replicas == 8.0));
    assert_eq!(column("window_end"), [10.0, 20.0, 30.0, 40.0].repeat(2));
    for engine in 0..2 {
        let late = [4 * engine + 2, 4 * engine + 3];
        let mean = late
            .iter()
            .map(|&row| 0.5 * found[row] / theory[row])
            .sum::<f64>();
        let squares = late
            .iter()
            .map(|&row| (0.5 * errors[row] / theory[row]).powi(2));
        let error = 1.02 * squares.sum::<f64>().sqrt();
        println!("engine {engine}: T/T_theory = {mean:.4} ± {error:.4}");
        let allowed = 0.011 + 5.41 * error;
        assert!((mean - 1.0).abs() < allowed, "{mean} ± {error}");
        assert!(allowed < 0.03, "the error bar {error} is too wide");
    }
}

/// Sizes, units and theory of two sizes of disks in a box.
#[test]
fn species_of_disks_give_sizes_and_units() {
    let bath = "[thermostat]\nkind = \"white-noise\"\nheating = 1\ninterval = 0.05\n";
    let binary = DRIVEN_MIXTURE.replace(bath, "");
    let plan = plan(&binary, &[]);
    let counts: Vec<usize> = plan.gas.species.iter().map(|one| one.count).collect();
    assert_eq!(counts, [63, 27]);
    // Means of diameter and mass are one: (0.7 + 0.3 2) = 1.3, (0.7 + 0.3 4) = 1.9.
    assert!((plan.scale.length - 1.3).abs() < 1e-12 && (plan.scale.mass - 1.9).abs() < 1e-12);
    assert_eq!([62, 63, 90].map(|index| plan.species_of(index)), [0, 1, 0]);
    let area = |one: &stosszahl::study::plan::SpeciesPlan| {
        one.count as f64 * std::f64::consts::PI * one.radius * one.radius
    };
    let covered: f64 = plan.gas.species.iter().map(area).sum();
    assert!((covered / plan.gas.volume / 0.2 - 1.0).abs() < 1e-12);
}

/// Partial temperatures, by the numbers of their disks, make up the energy of the gas, and every
/// collision is one of the three kinds of pairs.
#[test]
fn tables_of_species_add_up() {
    let work = TestFolder::new(DRIVEN_MIXTURE);
    work.done("run case.toml --out out");
    let out = work.path("out");
    let parts = Columns::read(&out, "species");
    let (time, species) = (parts.numbers("time"), parts.numbers("species"));
    let temperatures = parts.numbers("temperature");
    // In the units of the case, to three roundings.
    for (column, wanted) in [("mass", [1.0, 4.0]), ("diameter", [1.0, 2.0])] {
        let found = &parts.numbers(column)[..2];
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((found / wanted - 1.0).abs() < 1e-15, "{column}: {found}");
        }
    }
    let energy = Columns::read(&out, "energy");
    let rows = energy
        .numbers("time")
        .into_iter()
        .zip(energy.numbers("energy_ratio"));
    let mut count = 0;
    for ((when, whole), engine) in rows.zip(energy.texts("engine")) {
        let sum = |when: f64| {
            let part = |number: f64| {
                let own = (0..time.len()).find(|&row| {
                    parts.texts("engine")[row] == *engine
                        && time[row] == when
                        && species[row] == number
                });
                temperatures[own.expect("a species")]
            };
            63.0 * part(1.0) + 27.0 * part(2.0)
        };
        let ratio = sum(when) / sum(0.0);
        assert!(
            (ratio / whole - 1.0).abs() < 1e-12,
            "{when}: {ratio} {whole}"
        );
        count += 1;
    }
    assert!(count > 10, "{count} samples");
    let sum = |name| {
        Columns::read(&out, name)
            .numbers("count")
            .iter()
            .sum::<f64>()
    };
    let pairs = sum("impact_parameter_pairs");
    assert_eq!(pairs, sum("impact_parameter"));
    assert!(pairs > 300.0, "{pairs}");
}

/// The columns of theory are those of the equations solved here, and a measured value agrees with
/// them.
#[test]
fn theory_of_a_mixture_is_that_of_the_library() {
    // Without the tracers, whose density theory takes for zero.
    let text = MIXTURE
        .replace("[[species]]\nnumber = 100\nmass = 9\ntracer = true\n", "")
        .replace("[verdict]\nsonine_orders = 2\n", "");
    let work = TestFolder::new(&text);
    work.done("run case.toml --out out --replicas 3");
    let species = Columns::read(&work.path("out"), "species");
    let component = |mass, diameter, density| Component {
        mass,
        diameter,
        density,
    };
    let components = vec![component(1.0, 1.0, 0.1), component(4.0, 1.5, 500.0 / 2e4)];
    let law = Constant::new(0.8).expect("a coefficient");
    let mixture =
        MaxwellianMixture::new(3, components, law, ContactValues::Dilute).expect("a mixture");
    let (time, number) = (species.numbers("time"), species.numbers("species"));
    let times: Vec<f64> = time.iter().copied().step_by(2).collect();
    let orders = mixture.affordable_orders();
    assert_eq!(orders, 6);
    let curves = mixture.solve(orders, &[1.0, 2.0], &times).expect("smooth");
    for column in ["temperature_theory", "mean_squared_displacement_theory"] {
        for (row, found) in species.numbers(column).into_iter().enumerate() {
            let (moment, k) = (&curves[row / 2], number[row] as usize - 1);
            let exact = match column {
                "temperature_theory" => moment.temperatures[k],
                _ => moment.displacements[k],
            };
            // The same integration: only the writing and reading of numbers lies between.
            assert!(
                (found - exact).abs() <= 1e-12 * exact,
                "{column} {row}: {found} {exact}"
            );
        }
    }
    // 2000 light particles in each of three replicas know their temperature to 1 %; 6 % are six
    // standard errors.
    let last = time.len() - 2;
    let ratio = species.numbers("temperature")[last] / species.numbers("temperature_theory")[last];
    assert!((ratio - 1.0).abs() < 0.06, "{ratio}");
    let averaged = Columns::read(&work.path("out"), "time_averaged_displacement");
    assert!(
        averaged
            .numbers("mean_squared_displacement")
            .iter()
            .all(|&square| square > 0.0)
    );
}

const TWO: &str =
    "species = [{ number = 20000 }, { number = 20000, mass = 4, diameter = 1.5874 }]\n";

/// Sizes, numbers and laws from two equal shares to every particle its own, in both dimensions,
/// dilute and dense.
#[rustfmt::skip]
const CONTENTS: [(&str, &str, &str); 8] = [
    ("two", "dimension = 3", TWO),
    ("two disks", "dimension = 2", TWO),
    ("two, dense", "dimension = 3\npair_correlation = \"enskog\"", TWO),
    ("two disks, dense", "dimension = 2\npair_correlation = \"enskog\"", TWO),
    ("pairs", "dimension = 3", "species = [{ number = 20000 }, { number = 20000, mass = 4, diameter = 1.5874 }]\n\
        pair = [{ species = [1, 2], restitution = 0.6 }, { species = [2, 2], restitution = 1 }]\n"),
    ("three", "dimension = 3", "species = [{ number = 20000 }, { number = 20000, mass = 4, diameter = 1.5874 }, \
        { number = 20000, mass = 0.25, diameter = 0.63 }]\n"),
    ("hundred", "dimension = 3",
     "replicas = 16\npower_law = { monomers = 20000, exponent = 1, largest_mass = 100 }\n"),
    ("continuous", "dimension = 3",
     "polydisperse = { number = 60000, distribution = \"log-normal\", relative_width = 0.4, groups = 8 }\n"),
];

/// Partial temperatures follow the kinetic equations: to the error of their Sonine expansion where
/// there is one, and within 2 % in the first order where velocities are nearly Maxwellian, which it
/// assumes: a fourth cumulant below 0.03. Measured are those species whose temperature is known to
/// one percent; 4.5 standard errors beyond are a false alarm in 10^5 values.
#[test]
fn partial_temperatures_are_those_of_the_kinetic_equations() {
    let work = TestFolder::new("");
    for (name, gas, content) in CONTENTS {
        // Keys of the top level come before the tables.
        work.write(
            "case.toml",
            format!(
                "format = 2\ntitle = \"{name}\"\nseed = 5\n{content}\
                 [gas]\nvolume = 4e5\nrestitution = 0.9\n{gas}\n\
                 [run]\nuntil = 100\nfirst_sample = 1\nsamples_per_decade = 2\n"
            ),
        );
        work.done("run case.toml --force --out out");
        let species = Columns::read(&work.path("out"), "species");
        let column = |name| species.numbers(name);
        let (found, errors) = (column("temperature"), column("temperature_se"));
        let (theory, cumulants) = (column("temperature_theory"), column("fourth_cumulant"));
        let left = column("temperature_theory_error");
        let mut checked = 0;
        for row in 0..found.len() {
            let (ratio, error) = (found[row] / theory[row], errors[row] / theory[row]);
            // Error of the theory, which the first order does not have.
            let (allowed, applies) = if left[row].is_nan() {
                (0.02, cumulants[row].abs() < 0.03)
            } else {
                assert!(
                    left[row] < 0.005 * theory[row],
                    "{name}, row {row}: {}",
                    left[row]
                );
                (left[row] / theory[row], true)
            };
            if error < 0.01 && applies {
                let what = format!(
                    "{name}, row {row}: {ratio} +- {error}, a2 {}",
                    cumulants[row]
                );
                assert!((ratio - 1.0).abs() < allowed + 4.5 * error, "{what}");
                checked += 1;
            }
        }
        assert!(checked >= 6, "{name}: only {checked} of {}", found.len());
        // Temperatures differ and have fallen by a factor, so that the equations are tested.
        assert!(theory.last().is_some_and(|&last| last < 0.7), "{name}");
    }
}

#[test]
fn clusters_keep_mass_and_energy_in_their_tables() {
    let work = TestFolder::new(CLUSTERS);
    let said = work.done("run case.toml --out out");
    assert!(
        said.out.contains("second half of the steady state"),
        "{}",
        said.out
    );
    let out = work.path("out");
    let clusters = Columns::read(&out, "clusters");
    let column = |name| clusters.numbers(name);
    let (energy, stuck) = (column("energy_ratio"), column("aggregation_loss"));
    let (shattered, heated) = (column("fragmentation_loss"), column("heating_energy"));
    for row in 0..energy.len() {
        // Elastic bounces; some thousand events, each closed to a few roundings of energies below
        // ten.
        let sum = energy[row] + stuck[row] + shattered[row] - heated[row];
        assert!((sum - 1.0).abs() < 1e-11, "row {row}: {sum}");
    }
    assert!(stuck.last().is_some_and(|&stuck| stuck > 0.1));
    let sizes = Columns::read(&out, "size_distribution");
    let density = sizes.numbers("clusters_per_monomer");
    let (low, high) = (
        sizes.numbers("monomers_low"),
        sizes.numbers("monomers_high"),
    );
    let (average, time) = (sizes.texts("average"), sizes.numbers("time"));
    let single: Vec<usize> = (0..density.len())
        .filter(|&row| average[row] == "instant" && time[row] == 0.0)
        .collect();
    assert_eq!(single.len(), 1);
    assert_eq!((low[single[0]], density[single[0]]), (1.0, 1.0));
    // Mass in bins of one size is exact; wider bins know their middle only, which bounds it from
    // both sides.
    let mass = |edge: &[f64]| -> f64 {
        (0..density.len())
            .filter(|&row| average[row] == "steady")
            .map(|row| density[row] * edge[row] * (high[row] - low[row] + 1.0))
            .sum()
    };
    let (least, most) = (mass(&low), mass(&high));
    assert!(
        least <= 1.0 + 1e-12 && most >= 1.0 - 1e-12,
        "{least} {most}"
    );
}

/// Mass that flows in stays, leaves, or is split and merged; each boundary's share is reported.
#[test]
fn a_channel_balances() {
    let work = TestFolder::new(CHANNEL);
    work.done("run case.toml --out out");
    let boundaries = Columns::read(&work.path("out"), "boundaries");
    let names = boundaries.texts("boundary");
    for name in [
        "inflow 1",
        "out through right",
        "splitting and merging",
        "bottom",
    ] {
        assert!(names.iter().any(|one| one == name), "{name}");
    }
    let verdicts = manifest(&work.path("out")).verdicts;
    for words in [
        "of that of the inflow",
        "slip along the walls",
        "Whether the lower half and the upper half agree",
        "adds nothing",
    ] {
        assert!(
            verdicts.iter().any(|one| one.sentence.contains(words)),
            "{words}: {verdicts:?}"
        );
    }
}
