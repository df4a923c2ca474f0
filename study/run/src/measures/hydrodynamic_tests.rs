//! Spectra, scattering, distributions of velocities and transport coefficients, on small gases and
//! made-up records.

use stosszahl_analysis::spectra::{Shells, Spectra, Spectrum, SpectrumDisk};
use stosszahl_analysis::statistics::RunningMoments;
use stosszahl_analysis::structure_factor::direct_sum;
use stosszahl_results::{Table, VerdictKind};
use stosszahl_theory::transport;

use super::tests::{case, measure, near, number, run};
use crate::measure::{CompletedRun, ReplicaRecords, SampleProbe};
use crate::plan::CasePlan;

/// Disks in a square box, exact; options are those of the measure.
fn disks(restitution: f64, count: usize, packing: f64, until: f64, measure: &str) -> CasePlan {
    case(&format!(
        "format = 2\ntitle = \"disks\"\nreplicas = 1\n[gas]\nnumber = {count}\nrestitution = {restitution}\n\
         [box]\npacking_fraction = {packing}\n[run]\nuntil = {until}\n[engine.ed]\n[measure.{measure}"
    ))
}

/// Mean and standard error of a column over all rows of a table of one replica each.
fn moments(values: &[f64]) -> [f64; 2] {
    let all: RunningMoments = values.iter().copied().collect();
    [
        all.mean().expect("values"),
        all.standard_error().expect("values"),
    ]
}

/// An elastic gas in equilibrium: shear, sound and temperature have the spectra of fixed momentum
/// and energy, 1 + (1 - S)/(N - 1), the last times 1 - 2/N. Within z = 4.4 standard errors (false
/// alarm 1e-5 each), which see 3 %; replicas are independent, and the rows of one are averaged
/// first.
#[test]
fn an_elastic_gas_has_spectra_of_one() {
    let text = "spectra]\ntimes = [30, 40, 50, 60]\nlargest_wave_number = 4";
    let count = 64;
    let found: Vec<[f64; 4]> = (0..600)
        .map(|seed| {
            let mut plan = disks(1.0, count, 0.1, 60.0, text);
            plan.case.seed = seed;
            let (tables, _, _) = super::tests::run_from(&plan, measure("spectra"), seed);
            let spectra = &tables[0];
            let mean = |column: &str| {
                let rows = 0..spectra.rows.len();
                rows.map(|row| number(spectra, row, column)).sum::<f64>()
                    / spectra.rows.len() as f64
            };
            assert_eq!(number(spectra, 3, "s_perp_theory"), 1.0);
            ["s_nn", "s_perp", "s_par", "s_tt"].map(mean)
        })
        .collect();
    let column = |which: usize| -> Vec<f64> { found.iter().map(|one| one[which]).collect() };
    let structure = moments(&column(0))[0];
    // The fluid is less compressible than an ideal gas.
    assert!(structure < 0.9, "{structure}");
    let fixed = 1.0 + (1.0 - structure) / (count as f64 - 1.0);
    for (which, expected) in [
        (1, fixed),
        (2, fixed),
        (3, fixed * (1.0 - 2.0 / count as f64)),
    ] {
        let [mean, error] = moments(&column(which));
        let good = error < 0.03 / 4.4 && (mean - expected).abs() < 4.4 * error;
        assert!(good, "{which}: {mean} {error} {expected}");
    }
}

/// Tables of a measure of made-up records, one for each replica.
fn tables_of<R: Clone + serde::Serialize + serde::de::DeserializeOwned + Send + 'static>(
    plan: &CasePlan,
    name: &str,
    records: &[R],
) -> Vec<Table> {
    let finished = records.iter().map(|record| CompletedRun {
        probes: vec![Box::new(SampleProbe::new(
            record.clone(),
            |_: &mut R, _: &mut _| {},
        ))],
        work: stosszahl_model::WorkCounters::default(),
        bytes: 0,
        seconds: 0.0,
    });
    let finished = [finished.collect::<Vec<_>>()];
    let runs = ReplicaRecords {
        level: 0.01,
        measure: 0,
        finished: &finished,
    };
    measure(name).result_tables(plan, &runs)
}

/// Amplitudes of each mode that grow as a power of 1 + t/t0 beside noise that is across them: the
/// exponent of the growth is found. Theory of a shell of one wave number is that of the mode.
#[test]
fn growth_is_that_of_the_amplitudes() {
    let mut plan = disks(
        0.8,
        400,
        0.25,
        5.0,
        "spectra]\ntimes = [1, 5]\nlargest_wave_number = 2",
    );
    plan.case.replicas = 3;
    let shells =
        Shells::new([plan.gas.lengths[0], plan.gas.lengths[1]], &[1, 2], 48).expect("shells");
    let modes = shells.modes().indices().len();
    let span =
        0.5 * (plan.haff_ratio(1.0).expect("a law") / plan.haff_ratio(5.0).expect("a law")).ln();
    let records: Vec<Vec<(f64, Option<Spectra>)>> = (1..=3)
        .map(|replica| {
            let at = |grown: f64, noise: f64| Spectra {
                shells: vec![Spectrum::default(); 2],
                shear: (0..modes)
                    .map(|mode| {
                        let size = f64::from(replica) + mode as f64;
                        [size * grown, size * noise]
                    })
                    .collect(),
            };
            vec![
                (1.0, Some(at(1.0, 0.0))),
                (5.0, Some(at((0.7 * span).exp(), 2.0))),
            ]
        })
        .collect();
    let found = tables_of(&plan, "spectra", &records);
    let growth = &found[1];
    assert_eq!(growth.rows.len(), 2);
    for row in 0..2 {
        near(number(growth, row, "exponent"), 0.7, 10.0);
        near(number(growth, row, "exponent_se"), 0.0, 10.0);
    }
    // Shell 1 has the modes of k = 1 and of the root of 2: between the exponents of both.
    let critical = transport::critical_wave_number(0.25, plan.gas.contact_value, 0.8);
    let unit = std::f64::consts::TAU / plan.gas.lengths[0];
    let exponents = [1.0, 2.0_f64.sqrt()].map(|k| transport::shear_exponent(k * unit, critical));
    let theory = number(growth, 0, "exponent_theory");
    assert!(
        exponents[1] < theory && theory < exponents[0],
        "{theory} {exponents:?}"
    );
    let spectra = &found[0];
    let clock = -0.5 * plan.haff_ratio(5.0).expect("a law").ln();
    let mean =
        [1.0, 2.0_f64.sqrt()].map(|k| transport::thermal_shear_energy(k * unit, critical, clock));
    near(
        number(spectra, 2, "s_perp_theory"),
        0.5 * (mean[0] + mean[1]),
        100.0,
    );
}

/// Where velocities are scaled, all pairs of successive times are one: the exponent is that of the
/// amplitudes, and the viscosity is what is left of the growth without one, over Enskog's. Times
/// that are further apart are left out.
#[test]
fn decay_of_shear_tells_the_viscosity() {
    let text = "spectra]\ntimes = [1, 2, 3, 5]\nlargest_wave_number = 1\n[thermostat]\nkind = \"rescaling\"\ninterval = 0.5";
    let plan = disks(0.8, 40, 0.25, 5.0, text);
    let shells = Shells::new([plan.gas.lengths[0], plan.gas.lengths[1]], &[1], 48).expect("shells");
    let modes = shells.modes().indices().len();
    let reading = |time| plan.cooling_logarithm(time, true).expect("it cools");
    let at = |replica: i32, time: f64, size: f64| {
        let grown = (-0.6 * reading(time)).exp() * size;
        let shear = (0..modes).map(|mode| [f64::from(replica) * grown, mode as f64 * grown]);
        let spectra = Spectra {
            shells: vec![Spectrum::default(); 1],
            shear: shear.collect(),
        };
        (time, Some(spectra))
    };
    let one = |replica| {
        let times = [(1.0, 1.0), (2.0, 1.0), (3.0, 1.0), (5.0, 7.0)];
        times.map(|(time, size)| at(replica, time, size)).to_vec()
    };
    let tables = tables_of(&plan, "spectra", &[one(1), one(2), one(3)]);
    let decay = &tables[2];
    assert_eq!(decay.rows.len(), 1);
    near(number(decay, 0, "exponent"), -0.6, 10.0);
    near(number(decay, 0, "pairs"), 2.0, 1.0);
    let theory = number(decay, 0, "exponent_theory");
    let viscosity = number(decay, 0, "viscosity_over_enskog");
    near(viscosity, 1.6 / (1.0 - theory), 10.0);
}

/// The measures of exact disks against plain sums over the states of the same run.
#[test]
fn scattering_and_spectra_are_sums_over_states() {
    let plan = disks(
        0.9,
        60,
        0.2,
        4.0,
        "intermediate_scattering]\nfrom = 1\nwave_numbers = [2, 3]\n[measure.spectra]\ntimes = [0, 4]",
    );
    let (tables, _, log) = run(&plan, measure("intermediate_scattering"));
    let shells =
        Shells::new([plan.gas.lengths[0], plan.gas.lengths[1]], &[2, 3], 48).expect("shells");
    let lengths = [plan.gas.lengths[0], plan.gas.lengths[1]];
    let places = |state: usize| -> Vec<_> {
        log.states[state]
            .1
            .iter()
            .map(|one| one.position.xy())
            .collect()
    };
    // The state 0 is the start of the run, 1 that of the measurement.
    let looks = log.states.len() - 1;
    let table = &tables[0];
    assert_eq!(table.rows.len(), 2 * looks);
    for (shell, range) in shells.ranges().enumerate() {
        let modes = &shells.modes().indices()[range];
        let mean = |value: &dyn Fn([i32; 2]) -> f64| {
            modes.iter().map(|&index| value(index)).sum::<f64>() / modes.len() as f64
        };
        let first = mean(&|[x, y]| direct_sum(&places(1), lengths, x, y));
        near(number(table, shell * looks, "scattering"), first, 100.0);
        near(number(table, shell * looks, "correlation"), 1.0, 1.0);
        // Re(rho(t) rho*(0)) by the squares of sum and difference.
        let last = mean(&|[x, y]| {
            let k = [x, y].map(f64::from);
            let sum = |state: usize| {
                places(state).iter().fold([0.0; 2], |[re, im], at| {
                    let phase = std::f64::consts::TAU
                        * (k[0] * at.x / lengths[0] + k[1] * at.y / lengths[1]);
                    [re + phase.cos(), im - phase.sin()]
                })
            };
            let (a, b) = (sum(1), sum(looks));
            (a[0] * b[0] + a[1] * b[1]) / 60.0
        });
        let row = (shell + 1) * looks - 1;
        near(number(table, row, "scattering"), last, 100.0);
        near(number(table, row, "lag"), 3.0, 1.0);
    }
    let (tables, _, log) = run(&plan, measure("spectra"));
    let shells = Shells::new(lengths, &[1, 2, 3], 48).expect("shells");
    for (look, first) in [(1, 0), (2, tables[0].rows.len() / 2)] {
        let disks = log.states[look].1.iter().map(|one| SpectrumDisk {
            position: one.position.xy(),
            velocity: one.velocity.xy(),
            mass: one.mass,
        });
        let found = shells.measure(&disks.collect::<Vec<_>>()).expect("spectra");
        for (shell, expected) in found.shells.iter().enumerate() {
            let row = first + shell;
            near(number(&tables[0], row, "s_nn"), expected.density, 100.0);
            near(
                number(&tables[0], row, "s_perp"),
                expected.transverse,
                100.0,
            );
            near(number(&tables[0], row, "s_tt"), expected.temperature, 100.0);
        }
    }
}

/// Velocities of a gas of two species, species by species, against plain moments; densities have
/// the integral one.
#[test]
fn distributions_of_velocities_are_histograms() {
    let plan = case(
        "format = 2\ntitle = \"two\"\nreplicas = 1\ngas = { restitution = 0.9 }\n\
         species = [{ number = 40, name = \"a\" }, { number = 24, diameter = 2, mass = 3, name = \"b\" }]\n\
         box = { packing_fraction = 0.1 }\nrun = { until = 2 }\n\
         engine = { ed = {}, dsmc-boltzmann = { simulators_per_particle = 2 } }\n\
         measure.velocity_distribution = { times = [0, 2], bins = 20, range = 3, quantity = \"speed\" }",
    );
    let (tables, _, log) = run(&plan, measure("velocity_distribution"));
    let [densities, cumulants] = &tables[..] else {
        panic!("two tables")
    };
    assert_eq!((densities.rows.len(), cumulants.rows.len()), (160, 8));
    for rows in 0..8 {
        let sum: f64 = (0..20)
            .map(|bin| 0.15 * number(densities, 20 * rows + bin, "density"))
            .sum();
        near(sum + number(cumulants, rows, "beyond"), 1.0, 1.0);
        assert!(number(cumulants, rows, "a2_theory").is_nan());
    }
    // The last engine at the last time: the second species.
    let all = &log.states[2].1;
    let own: Vec<_> = all
        .iter()
        .enumerate()
        .filter(|(index, _)| index % 64 >= 40)
        .collect();
    assert_eq!(own.len(), 48);
    let count = own.len() as f64;
    let drift = own
        .iter()
        .map(|(_, one)| one.velocity)
        .sum::<nalgebra::Vector3<f64>>()
        / count;
    let power = |power: i32| {
        let all = own
            .iter()
            .map(|(_, one)| (one.velocity - drift).norm().powi(power));
        all.sum::<f64>() / count
    };
    let n = 2.0 * (count - 1.0);
    let a2 = power(4) / (2.0 * power(2).powi(2)) * (n + 2.0) / n - 1.0;
    near(number(cumulants, 7, "a2"), a2, 10.0);
    let sixth = power(6) / (6.0 * power(2).powi(3)) * (n + 2.0) * (n + 4.0) / (n * n);
    near(number(cumulants, 7, "a3"), 1.0 + 3.0 * a2 - sixth, 10.0);
}

/// The record of exact disks against the same sums fed with the collisions of the run.
#[test]
fn transport_is_measured_from_the_collisions_of_the_run() {
    let plan = disks(1.0, 40, 0.2, 40.0, "transport]\nlag = 4\npoints = 8");
    let (tables, verdicts, log) = run(&plan, measure("transport"));
    let bin = plan.engine_time(4.0) / 8.0;
    let velocities = log.states[0].1.iter().map(|one| one.velocity.xy());
    let mut plain =
        stosszahl_analysis::helfand::Helfand::new(0.0, velocities, 1.0, plan.gas.volume, bin, 8);
    for collision in &log.collisions {
        plain.collide(collision);
    }
    plain.advance(plan.engine_time(40.0));
    let moments = plain.moments();
    let slope = |of: &dyn Fn(usize) -> f64| (of(7) - of(3)) / (moments[7].lag - moments[3].lag);
    let expected = [
        ("self_diffusion", slope(&|at| moments[at].diffusion)),
        (
            "shear_viscosity",
            slope(&|at| moments[at].shear.iter().sum()),
        ),
        ("shear_viscosity_kinetic", slope(&|at| moments[at].shear[0])),
        ("shear_viscosity_cross", slope(&|at| moments[at].shear[1])),
        (
            "shear_viscosity_collisional",
            slope(&|at| moments[at].shear[2]),
        ),
        ("bulk_viscosity", slope(&|at| moments[at].bulk)),
        (
            "heat_conductivity",
            slope(&|at| moments[at].heat.iter().sum()),
        ),
        ("heat_conductivity_cross", slope(&|at| moments[at].heat[1])),
    ];
    let [coefficients, lags, _] = &tables[..] else {
        panic!("three tables")
    };
    assert_eq!((coefficients.rows.len(), lags.rows.len()), (1, 32));
    for (column, expected) in expected {
        near(number(coefficients, 0, column), expected, 10.0);
        if let Some(over) = coefficients.find_column(&format!("{column}_over_enskog")) {
            let over = &coefficients.columns[over].name;
            let theory = number(coefficients, 0, &format!("{column}_theory"));
            near(number(coefficients, 0, over) * theory, expected, 10.0);
        }
    }
    near(number(lags, 7, "lag"), 4.0, 1.0);
    assert_eq!(verdicts.len(), measure("transport").test_count(&plan));
    for verdict in &verdicts {
        // One replica has no errors.
        assert_eq!(verdict.kind, VerdictKind::Undecided, "{}", verdict.sentence);
        let said = &verdict.sentence;
        assert!(said.ends_with("; one replica has no error."), "{said}");
    }
    let said = &verdicts[1].sentence;
    assert!(
        said.starts_with("Whether ED (exact) and Enskog's theory agree in shear viscosity within 5 % is undecided: "),
        "{said}"
    );
    // A coarse check of the units: a factor of two would be seen.
    let diffusion = number(coefficients, 0, "self_diffusion_over_enskog");
    assert!((0.6..1.6).contains(&diffusion), "{diffusion}");
}

#[test]
fn options_that_cannot_be_are_refused() {
    let refused = |restitution: f64, text: &str, key: &str| {
        let name = text.split(']').next().expect("a name");
        let plan = disks(restitution, 40, 0.2, 40.0, text);
        let error = measure(name).check_options(&plan).expect_err(text);
        assert_eq!(error.key, key, "{error}");
        error.allowed
    };
    for (text, key) in [
        ("spectra]\ninterval = 0", "interval"),
        ("spectra]\ninterval = 1\ntimes = [0]", "interval"),
        ("spectra]\nlargest_wave_number = 0", "largest_wave_number"),
        ("spectra]\nmodes_per_shell = 5000", "modes_per_shell"),
        (
            "intermediate_scattering]\nwave_numbers = []",
            "wave_numbers",
        ),
        (
            "intermediate_scattering]\nwave_numbers = [3, 3]",
            "wave_numbers",
        ),
        (
            "intermediate_scattering]\nwave_numbers = [0]",
            "wave_numbers",
        ),
        ("velocity_distribution]\nbins = 1", "bins"),
        ("velocity_distribution]\nrange = 0", "range"),
        ("velocity_distribution]\nquantity = \"energy\"", "quantity"),
        ("transport]\nlag = 30", "lag"),
        ("transport]\npoints = 5", "points"),
    ] {
        refused(1.0, text, key);
    }
    let allowed = refused(0.9, "transport]", "");
    assert!(allowed.starts_with("an elastic gas"), "{allowed}");
    let mut plan = disks(1.0, 40, 0.2, 40.0, "transport]");
    plan.engines.clear();
    assert!(measure("transport").check_options(&plan).is_err());
}
