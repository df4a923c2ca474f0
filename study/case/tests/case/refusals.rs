//! Each kind of refusal names its key and what is allowed.

use std::path::Path;

use proptest::prelude::*;
use stosszahl_case::{CaseError, CaseFile, Format, schema_of};

const COMPARISON: &str = r#"format = 2
title = "Disks"
replicas = 2
[gas]
number = 1000
restitution = 0.9
[box]
packing_fraction = 0.1
[run]
until = 10
[engine.ed]
[engine.dsmc-contact-point]
"#;

const FLOW: &str = r#"format = 2
title = "Channel"
[gas]
[[species]]
number = 100
[[species]]
number = 50
mass = 2
[box]
size = [40, 20]
[walls]
left = "open"
right = "open"
bottom = "specular"
top = { restitution = 0.9, slip = 0.5 }
[[inflow]]
face = "left"
velocity = [1, 0]
[[obstacle]]
circle = { centre = [10, 10], radius = 2 }
[run]
until = 10
[engine.dsmc-boltzmann]
"#;

const HOMOGENEOUS: &str = r#"format = 2
title = "Mixture"
[gas]
dimension = 3
volume = 1000
[[species]]
number = 100
[[species]]
number = 100
mass = 2
[run]
until = 10
[measure.displacement]
"#;

fn read(text: &str, set: &[&str]) -> Result<CaseFile, CaseError> {
    let set: Vec<String> = set.iter().map(|&one| one.to_owned()).collect();
    CaseFile::from_text(Path::new("case.toml"), text, &set)
}

/// Settings, the key that is refused, and words of the message.
type Row = (&'static [&'static str], &'static str, &'static str);

fn refused(text: &str, rows: &[Row]) {
    if let Err(error) = read(text, &[]) {
        panic!("{}", error.report(false));
    }
    for (set, key, words) in rows {
        let Err(error) = read(text, set) else {
            panic!("{set:?} was taken");
        };
        let message = error.to_string();
        let refusal = error.refusal().unwrap_or_else(|| panic!("{message}"));
        assert_eq!(refusal.key, *key, "{set:?}: {message}");
        assert!(message.contains(words), "{set:?}: {message}");
        assert!(!error.report(true).is_empty());
    }
}

#[test]
fn values_out_of_range_are_refused() {
    refused(
        COMPARISON,
        &[
            (
                &["gas.restitution=1.5"],
                "gas.restitution",
                "a number from 0 to 1",
            ),
            (
                &["gas.restitution=soft"],
                "gas.restitution",
                "or a table with the keys poisson_ratio, viscoelastic, viscosities, young_modulus",
            ),
            (
                &["gas.restitution={ young_modulus = 1e6, poisson_ratio = 0.3 }"],
                "gas.restitution",
                "young_modulus, poisson_ratio and viscosities",
            ),
            (
                &["gas.restitution={ viscoelastic = 0.3, poisson_ratio = 0.3 }"],
                "gas.restitution",
                "{ viscoelastic = STRENGTH }, or",
            ),
            (
                &[
                    "gas.restitution={ young_modulus = 1e6, poisson_ratio = 0.6, viscosities = [1, 1] }",
                ],
                "gas.restitution.poisson_ratio",
                "above -1 and at most 0.5",
            ),
            (
                &["gas.restitution={ viscoelastic = 0 }"],
                "gas.restitution.viscoelastic",
                "above 0",
            ),
            (
                &["gas.number=1000.5"],
                "gas.number",
                "a whole number from 1 to 2000000000",
            ),
            (&["gas.number=1"], "gas.number", "at least 2"),
            (&["gas.dimension=4"], "gas.dimension", "from 2 to 3"),
            (&["replicas=0"], "replicas", "from 1 to 1000000"),
            (&["title=\"\""], "title", "a text"),
            (&["units=sii"], "units", "did you mean \"si\"?"),
            (&["seed=-1"], "seed", "from 0 to 9223372036854775807"),
            (
                &["box.packing_fraction=0.95"],
                "box.packing_fraction",
                "at most 0.9069",
            ),
            (
                &["run.first_sample=5e-324"],
                "run.first_sample",
                "size from 1e-100",
            ),
            (&["run.until=inf"], "run.until", "size from"),
            (&["gas.diameter=nan"], "gas.diameter", "size from"),
            (
                &["run.first_sample=10"],
                "run.first_sample",
                "below run.until = 10",
            ),
            (
                &["run.time_unit=haf"],
                "run.time_unit",
                "did you mean \"haff\"?",
            ),
            (
                &["verdict.family_wise_error_rate=0.5"],
                "verdict.family_wise_error_rate",
                "at least 1e-12 and below 0.5",
            ),
            (
                &["engine.ed.contact_time=-1"],
                "engine.ed.contact_time",
                "at least 0",
            ),
            (
                &["engine.dsmc-enskog.density_window=60"],
                "engine.dsmc-enskog.density_window",
                "from 0 to 50",
            ),
            (
                &["engine.dsmc-enskog.density_window=men"],
                "engine.dsmc-enskog.density_window",
                "\"mean\"",
            ),
            (
                &["accuracy.target=2"],
                "accuracy.target",
                "a share in quotes",
            ),
            (
                &["seed=9223372036854775808"],
                "seed",
                "from 0 to 9223372036854775807",
            ),
        ],
    );
}

#[test]
fn unknown_keys_are_refused_with_the_nearest() {
    refused(
        COMPARISON,
        &[
            (
                &["gas.restitutoin=0.9"],
                "gas.restitutoin",
                "did you mean restitution?",
            ),
            (&["gass.number=3"], "gass", "did you mean gas?"),
            (&["gas.until=3"], "gas.until", "did you mean run.until?"),
            (&["gas.gravity=1"], "gas.gravity", "did you mean gravity?"),
            (
                &["coalescence={}"],
                "coalescence",
                "did you mean aggregation?",
            ),
            (
                &["box.volume_fraction=0.1"],
                "box.volume_fraction",
                "did you mean packing_fraction?",
            ),
            (
                &["run.contact_time=1"],
                "run.contact_time",
                "did you mean engine.ed.contact_time?",
            ),
            (
                &["engine.dsmc-enskg={}"],
                "engine.dsmc-enskg",
                "did you mean dsmc-enskog?",
            ),
            (
                &["run.fist_sample=1"],
                "run.fist_sample",
                "did you mean first_sample?",
            ),
            (
                &["species.1.number=3", "species.1.nmber=3"],
                "species.1.nmber",
                "did you mean number?",
            ),
        ],
    );
}

const OF_COMPARISONS: &[Row] = &[
    (
        &["species.1.number=3"],
        "species",
        "gas.number gives it too",
    ),
    (&["species.1.share=0.5"], "species.1.share", "add up to 1"),
    (
        &["species.1.share=1", "gas.diameter=2"],
        "gas.diameter",
        "species says this",
    ),
    (
        &["box.size=[10, 10]"],
        "box.packing_fraction",
        "either a size or a packing_fraction",
    ),
    (
        &["box.width_over_critical_length=0.5"],
        "box.width_over_critical_length",
        "gas.number gives it too",
    ),
    (&["gas.volume=3"], "gas.volume", "without positions"),
    (
        &["gas.particles_per_simulator=3"],
        "gas.particles_per_simulator",
        "gas.mean_free_path",
    ),
    (
        &["thermostat={ kind = 'rescaling', interval = 1e9 }"],
        "thermostat.interval",
        "below run.until",
    ),
    (
        &["thermostat={ kind = 'rescaling' }"],
        "thermostat.interval",
        "needs",
    ),
    (
        &["thermostat.interval=1"],
        "thermostat.kind",
        "\"langevin\"",
    ),
    (
        &["thermostat={ kind = 'rescaling', interval = 1, drag = 1 }"],
        "thermostat.drag",
        "\"langevin\"",
    ),
    (
        &["thermostat={ kind = 'white-noise', interval = 1 }"],
        "thermostat.heating",
        "needs",
    ),
    (
        &["thermostat={ kind = 'white-noise', heating = 1, interval = 1, bath_temperature = 1 }"],
        "thermostat.bath_temperature",
        "\"langevin\"",
    ),
    (
        &["thermostat={ kind = 'white-noise', heating = -1, interval = 1 }"],
        "thermostat.heating",
        "above 0",
    ),
    (
        &["thermostat={ kind = 'langevin' }"],
        "thermostat.drag",
        "needs",
    ),
    (
        &["thermostat={ kind = 'langevin', drag = 1, heating = 1 }"],
        "thermostat.heating",
        "\"white-noise\"",
    ),
    (
        &["thermostat={ kind = 'langevin', drag = -1 }"],
        "thermostat.drag",
        "above 0",
    ),
    (
        &["thermostat={ kind = 'langevin', drag = 0 }"],
        "thermostat.drag",
        "above 0",
    ),
    (
        &["thermostat={ kind = 'langevin', drag = inf, bath_temperature = inf }"],
        "thermostat.bath_temperature",
        "have a size from",
    ),
    (
        &["thermostat={ kind = 'langevin', drag = 1, bath_temperature = inf }"],
        "thermostat.bath_temperature",
        "have a size from",
    ),
    (
        &["thermostat={ kind = 'langevin', drag = 1, bath_temperature = 0 }"],
        "thermostat.bath_temperature",
        "above 0",
    ),
    (
        &["thermostat={ kind = 'langevin', drag = 1, interval = 10 }"],
        "thermostat.interval",
        "below run.until",
    ),
    (
        &["thermostat={ kind = 'langevin', drag = 1000, interval = 1 }"],
        "thermostat.interval",
        "over the drag",
    ),
    (
        &["thermostat={ kind = 'white-noise', heating = 1, interval = 20 }"],
        "thermostat.interval",
        "below run.until",
    ),
    (
        &[
            "thermostat={ kind = 'rescaling', interval = 1 }",
            "gravity.acceleration=[0, -1]",
        ],
        "thermostat.kind",
        "gravity",
    ),
    (
        &[
            "thermostat={ kind = 'rescaling', interval = 1 }",
            "gas.tangential_restitution=0.5",
        ],
        "thermostat.kind",
        "spin",
    ),
    (
        &[
            "thermostat={ kind = 'white-noise', heating = 1, interval = 1 }",
            "gravity.acceleration=[0, -1]",
        ],
        "thermostat.kind",
        "falls",
    ),
    (&["aggregation={}"], "aggregation", "without positions"),
    (
        &["power_law={ monomers = 3, exponent = 3 }"],
        "power_law",
        "without positions",
    ),
    (
        &["engine.dsmc-homogeneous={}"],
        "engine.dsmc-homogeneous",
        "without a [box]",
    ),
    (
        &["gas.dimension=3"],
        "engine.ed",
        "exact dynamics is of disks",
    ),
    (
        &["gas.reduced_inertia=0.5"],
        "gas.reduced_inertia",
        "grains that spin",
    ),
    (
        &["start.spin_temperature=0.5"],
        "start.spin_temperature",
        "grains that spin",
    ),
    (&["start.empty=true"], "start.empty", "[[inflow]]"),
    (
        &["start.velocity=[1, 0]"],
        "start.velocity",
        "the same gas as one at rest",
    ),
    (
        &["gas.tangential_restitution=0", "start.velocity=[1, 0]"],
        "start.velocity",
        "the same gas as one at rest",
    ),
    (
        &[
            "gas.tangential_restitution=0",
            "engine.dsmc-contact-point.simulator_start=coherent",
        ],
        "engine.dsmc-contact-point.simulator_start",
        "particles that spin",
    ),
    (
        &[
            "gravity.acceleration=[0, -1]",
            "engine.dsmc-contact-point.simulator_start=coherent",
        ],
        "engine.dsmc-contact-point.simulator_start",
        "a start of its own",
    ),
    (
        &["gas.number=1", "gas.tangential_restitution=0"],
        "gas.number",
        "at least 2 particles",
    ),
    (
        &["start.file=a.csv"],
        "start.file",
        "with placement = \"file\"",
    ),
    (
        &["start.placement=file"],
        "start.placement",
        "gas.number gives it too",
    ),
    (
        &["start.velocities=file"],
        "start.velocities",
        "gas.number gives it too",
    ),
    (
        &["start.velocities={ a2 = 11 }"],
        "start.velocities.a2",
        "10",
    ),
    (&["start.region=[[0, 0], [1]]"], "start.region.2", "2"),
    (
        &["start.region=[[2, 0], [1, 3]]"],
        "start.region",
        "not empty",
    ),
    (
        &["start.region=[[0, 0, 0], [1, 3, 4]]"],
        "start.region",
        "2 numbers",
    ),
    (
        &["start.region=[[0, 0], [1, 3]]", "start.placement=square"],
        "start.region",
        "disordered",
    ),
    (
        &["start.region=[[0, 0], [1, 3]]", "start.equilibration=1"],
        "start.equilibration",
        "spreads the gas",
    ),
    (
        &["start.placement=square", "box.packing_fraction=0.8"],
        "box.packing_fraction",
        "square lattice",
    ),
    (
        &["start.equilibration=10", "start.longest_equilibration=5"],
        "start.longest_equilibration",
        "at least start.equilibration",
    ),
    (
        &["gas.temperature=1", "gas.rms_speed=1"],
        "gas.rms_speed",
        "only one of the two",
    ),
    (&["units=si"], "gas.diameter", "units = \"si\""),
    (
        &["units=si", "gas.diameter=1", "gas.mass=1"],
        "gas.temperature",
        "units = \"si\"",
    ),
    (
        &["gas.mean_free_path=1"],
        "gas.mean_free_path",
        "the box has a size",
    ),
    (
        &["drive={ heating = 1, interval = 1 }"],
        "drive",
        "[thermostat] with kind = \"white-noise\"",
    ),
    (
        &["run.samples=10", "run.first_sample=1"],
        "run.first_sample",
        "equal intervals",
    ),
    (
        &["engine.dsmc-contact-point.stiffness=1"],
        "engine.dsmc-contact-point.stiffness",
        "its keys are",
    ),
    (
        &["engine.dsmc-boltzmann.steps_per_mean_free_time=8"],
        "engine.dsmc-boltzmann.steps_per_mean_free_time",
        "its keys are",
    ),
    (
        &["engine.dsmc-contact-point.wall_contact=centre"],
        "engine.dsmc-contact-point.wall_contact",
        "needs walls",
    ),
    (
        &[
            "thermostat={ kind = 'white-noise', heating = 1, interval = 0.1 }",
            "engine.dsmc-boltzmann.weights={ along = \"x\", factors = [1] }",
        ],
        "engine.dsmc-boltzmann.weights",
        "equal weight",
    ),
    (
        &["pair.1={ species = [1, 2], restitution = 0.5 }"],
        "pair.1.species",
        "counted from 1",
    ),
    (
        &["measure.snapshots.times=[0, 20]"],
        "measure.snapshots.times.2",
        "run.until = 10",
    ),
    (
        &["measure.impact_parameters.windows=[[0, 1], [3, 2]]"],
        "measure.impact_parameters.windows.2",
        "start < end",
    ),
    (
        &["measure.impact_parameters.windows=[[0, 11]]"],
        "measure.impact_parameters.windows.1",
        "0 <= start < end <= run.until = 10.0",
    ),
    (
        &["measure.spectra.times=[-1]"],
        "measure.spectra.times.1",
        "from 0 to run.until = 10.0",
    ),
    (
        &["measure.clusters.steady_from=-1"],
        "measure.clusters.steady_from",
        "from 0 to below run.until = 10.0",
    ),
    (
        &["measure.structure_factor.times=[50]"],
        "measure.structure_factor.times.1",
        "from 0 to run.until = 10.0",
    ),
    (
        &["measure.clusters.times=[11]"],
        "measure.clusters.times.1",
        "from 0 to run.until = 10.0",
    ),
    (
        &["measure.fields.windows=[[0, 4], [3, 2]]"],
        "measure.fields.windows.2",
        "start < end",
    ),
    (
        &["measure.intermediate_scattering.from=40"],
        "measure.intermediate_scattering.from",
        "below run.until = 10.0",
    ),
    (
        &["measure.collision_log.from=21"],
        "measure.collision_log.from",
        "below run.until = 10.0",
    ),
    (
        &["measure.displacement.from=10"],
        "measure.displacement.from",
        "below run.until",
    ),
];

#[test]
fn relations_of_comparisons_are_checked() {
    refused(COMPARISON, OF_COMPARISONS);
}

/// A box in critical lengths is allowed for cooling equal disks only.
#[test]
fn relations_of_boxes_in_critical_lengths_are_checked() {
    let text = COMPARISON
        .replace("number = 1000\n", "")
        .replace("[box]\n", "[box]\nwidth_over_critical_length = 0.8\n");
    assert!(read(&text, &[]).is_ok());
    let cools = "disks that cool in a periodic box";
    let rows: &[Row] = &[
        (
            &["gas.number=100"],
            "box.width_over_critical_length",
            "gas.number gives it too",
        ),
        (
            &["gas.restitution=1"],
            "box.width_over_critical_length",
            cools,
        ),
        (
            &["thermostat={ kind = 'white-noise', heating = 1, interval = 1 }"],
            "box.width_over_critical_length",
            cools,
        ),
        (
            &["gravity.acceleration=[0, -1]"],
            "box.width_over_critical_length",
            cools,
        ),
        (
            &["box.width_over_critical_length=0"],
            "box.width_over_critical_length",
            "above 0",
        ),
    ];
    refused(&text, rows);
}

/// A uniform shear flow is allowed for exact disks and for Monte Carlo within cells, in a periodic
/// box.
#[test]
fn relations_of_sheared_boxes_are_checked() {
    let text = "format = 2\ntitle = \"sheared\"\n[gas]\nnumber = 100\nrestitution = 0.9\n[box]\npacking_fraction = 0.2\n\
                shear_rate = 0.5\n[run]\nuntil = 1\n[engine.ed]\n";
    assert!(read(text, &[]).is_ok());
    assert!(read(text, &["box.shear_rate=-2"]).is_ok());
    for engines in [
        "engine={ ed = {}, dsmc-boltzmann = {}, dsmc-free-volume = {}, dsmc-enskog = {} }",
        "engine={ dsmc-esmc = {}, dsmc-stochastic-disks = {}, dsmc-contact-point = {} }",
    ] {
        assert!(read(text, &[engines]).is_ok());
    }
    assert!(read(text, &["gas.tangential_restitution=0.5"]).is_ok());
    let rows: &[Row] = &[
        (&["box.shear_rate=0"], "box.shear_rate", "not 0"),
        (&["box.shear_rate=inf"], "box.shear_rate", "1e-100 to 1e100"),
        (&["box.shear_rate=nan"], "box.shear_rate", "1e-100 to 1e100"),
        (
            &["walls.bottom=\"specular\"", "walls.top=\"specular\""],
            "box.shear_rate",
            "without [walls]",
        ),
        (
            &["walls.left=\"specular\"", "walls.right=\"specular\""],
            "box.shear_rate",
            "without [walls]",
        ),
        (
            &["gravity.acceleration=[0, -1]"],
            "box.shear_rate",
            "without [gravity]",
        ),
        (
            &["obstacle=[{ circle = { centre = [1, 1], radius = 0.5 } }]"],
            "box.shear_rate",
            "obstacle",
        ),
        (
            &["engine={ ed = {}, dsmc-enskog = { displacement = true } }"],
            "engine.dsmc-enskog.displacement",
            "contact distance",
        ),
    ];
    refused(text, rows);
}

const OF_FLOWS: &[Row] = &[
    (
        &["engine.dsmc-boltzmann.weights={ along = \"x\" }"],
        "engine.dsmc-boltzmann.weights",
        "either factors, or a number of stripes",
    ),
    (
        &["engine.dsmc-boltzmann.weights={ along = \"x\", factors = [1], adaptive_stripes = 4 }"],
        "engine.dsmc-boltzmann.weights",
        "either factors, or a number of stripes",
    ),
    (
        &["box.size=[40, 20, 10]"],
        "box.size",
        "a list of 2 numbers",
    ),
    (&["box.size=[40]"], "box.size", "a list of 2 to 3"),
    (&["box.size=[10, 10]"], "box.size", "at most 0.9069"),
    (
        &["gravity.acceleration=[0, 0, 1]"],
        "gravity.acceleration",
        "a list of 2 numbers",
    ),
    (
        &["walls.back=specular", "walls.front=specular"],
        "walls.back",
        "third axis",
    ),
    (
        &["walls.top=periodic"],
        "walls.bottom",
        "walls.top is periodic",
    ),
    (
        &["inflow={ face = \"left\" }"],
        "inflow",
        "did you mean [[inflow]]?",
    ),
    (
        &["walls.top=hard"],
        "walls.top",
        "did you mean \"specular\"?",
    ),
    (
        &["walls.top.amplitude=1"],
        "walls.top.amplitude",
        "did you mean walls.top.vibration.amplitude?",
    ),
    (
        &["walls.top.temperature=1"],
        "walls.top.temperature",
        "or else restitution",
    ),
    (
        &["walls.top={ slip = 1 }"],
        "walls.top.restitution",
        "a restitution from 0 to 1",
    ),
    (
        &["walls.top.sliding=[1, 1]"],
        "walls.top.sliding",
        "zero across",
    ),
    (
        &["walls.top.vibration={ amplitude = 10, period = 1 }"],
        "walls.top.vibration.amplitude",
        "below half",
    ),
    (
        &["walls.top=closed"],
        "walls.top",
        "\"periodic\", \"specular\", \"open\", or a table",
    ),
    (
        &["inflow.1.face=top"],
        "inflow.1.face",
        "walls.top = \"open\"",
    ),
    (
        &["inflow.1.face=letf"],
        "inflow.1.face",
        "did you mean \"left\"?",
    ),
    (
        &["inflow.1.velocity=[1, 0, 0]"],
        "inflow.1.velocity",
        "a list of 2 numbers",
    ),
    (
        &["inflow.1.number_density=[1]"],
        "inflow.1.number_density",
        "a list of 2",
    ),
    (
        &["inflow.1.spin_temperature=1"],
        "inflow.1.spin_temperature",
        "grains that spin",
    ),
    (&["inflow.3.face=left"], "inflow.3.face", "this list has 1"),
    (&["inflow.0.face=left"], "inflow.0.face", "this list has 1"),
    (
        &["inflow=[]", "start.empty=true"],
        "start.empty",
        "needs an [[inflow]]",
    ),
    (
        &["obstacle.1.polygon=[[1, 1], [2, 1], [2, 2]]"],
        "obstacle.1",
        "exactly one",
    ),
    (
        &["obstacle.1.circle.centre=[50, 1]"],
        "obstacle.1.circle.centre",
        "in the box",
    ),
    (
        &["obstacle.2.polyline=[[1, 1], [2, 30]]"],
        "obstacle.2.polyline.2",
        "in the box",
    ),
    (
        &["obstacle.1.slip=0", "obstacle.1.temperature=1"],
        "obstacle.1.temperature",
        "or else restitution",
    ),
    (&["engine.ed={}"], "walls.left", "no open face"),
    (
        &["engine.dsmc-contact-point={}"],
        "engine.dsmc-contact-point",
        "obstacles go with",
    ),
    (
        &["engine.dsmc-esmc={}"],
        "engine.dsmc-esmc",
        "obstacles go with",
    ),
    (
        &["engine.dsmc-enskog.density_window=mean"],
        "engine.dsmc-enskog.density_window",
        "ends at obstacles",
    ),
    (
        &["thermostat={ kind = 'rescaling', interval = 1 }"],
        "thermostat.kind",
        "periodic on",
    ),
    (
        &["species.1.tracer=true"],
        "species.1.tracer",
        "without a box",
    ),
    (&["species.1.number=0"], "species.1.number", "at least 1"),
    (
        &["species.1.number_density=1"],
        "species.1.number_density",
        "a species has a number",
    ),
    (&["species.1.name=all"], "species.1.name", "none is \"all\""),
    (
        &["species.1.name=2"],
        "species.2.name",
        "differ from each other",
    ),
    (
        &["species.1.name=\"2\""],
        "species.2.name",
        "differ from each other",
    ),
    (
        &["species.2.share=0.5"],
        "species.2.share",
        "a species has a number",
    ),
    (
        &["gas.mean_free_path=1", "engine.dsmc-enskog={}"],
        "gas.mean_free_path",
        "runs alone",
    ),
];

#[test]
fn relations_of_flows_are_checked() {
    refused(FLOW, OF_FLOWS);
}

#[test]
#[expect(clippy::too_many_lines, reason = "a table of refusals")]
fn relations_of_gases_without_positions_are_checked() {
    refused(
        HOMOGENEOUS,
        &[
            (&["engine.ed={}"], "engine.ed", "needs a [box]"),
            (
                &["engine.dsmc-enskog={}"],
                "engine.dsmc-enskog",
                "needs a [box]",
            ),
            (
                &["gas.tangential_restitution=1"],
                "gas.tangential_restitution",
                "needs a [box]",
            ),
            (
                &["start.equilibration=1"],
                "start.equilibration",
                "needs a [box]",
            ),
            (
                &["start.region=[[0, 0], [1, 1]]"],
                "start.region",
                "needs a [box]",
            ),
            (
                &["gas.dimension=3", "start.velocities={ a2 = -0.45 }"],
                "start.velocities.a2",
                "from -0.4",
            ),
            (
                &["gravity.acceleration=[0, 0, 1]"],
                "gravity",
                "needs a [box]",
            ),
            (
                &["power_law={ monomers = 3, exponent = 3 }"],
                "power_law",
                "species gives it too",
            ),
            (
                &["species.1.number=0", "species.2.number=0"],
                "species",
                "from 1 to 2147483647",
            ),
            (
                &["species.1.tracer=true", "species.2.tracer=true"],
                "species.1.tracer",
                "one species at most",
            ),
            (&["aggregation={}"], "aggregation", "exactly one species"),
            (
                &[
                    "species=[{ number = 10 }]",
                    "aggregation.fragment_energy_part=normal",
                ],
                "aggregation.fragment_energy_part",
                "for a threshold",
            ),
            (
                &[
                    "species=[{ number = 10 }]",
                    "aggregation={}",
                    "run.time_unit=haff",
                ],
                "run.time_unit",
                "no cooling time",
            ),
            (
                &["thermostat={ kind = 'rescaling', interval = 1 }"],
                "thermostat",
                "aggregation.fragment_above",
            ),
            (
                &["thermostat={ kind = 'langevin', drag = 1 }"],
                "thermostat.kind",
                "without positions",
            ),
            (
                &["gas.pair_correlation=enskog", "gas.volume=50"],
                "gas.volume",
                "fill less than all",
            ),
            (
                &["pair.1={ species = [1, 3], restitution = 0.5 }"],
                "pair.1.species",
                "two of the 2 species",
            ),
        ],
    );
    let law = HOMOGENEOUS.replace(
        "[[species]]\nnumber = 100\n[[species]]\nnumber = 100\nmass = 2\n",
        "[power_law]\nmonomers = 100\nexponent = 2\n",
    );
    refused(
        &law,
        &[
            (
                &["power_law.exponent=0"],
                "power_law.largest_mass",
                "do not fall to zero",
            ),
            (
                &[
                    "power_law.exponent=0",
                    "power_law.largest_mass=1e5",
                    "power_law.monomers=1e6",
                ],
                "power_law.monomers",
                "together",
            ),
            (&["gas.diameter=2"], "gas.diameter", "power_law says this"),
            (
                &["power_law.roundin=down"],
                "power_law.roundin",
                "did you mean rounding?",
            ),
        ],
    );
}

#[test]
fn missing_keys_are_named() {
    for (without, key) in [
        ("until = 10\n", "run.until"),
        ("[run]\nuntil = 10\n", "run"),
        ("number = 1000\n", "gas.number"),
        ("packing_fraction = 0.1\n", "box.packing_fraction"),
        ("[engine.ed]\n[engine.dsmc-contact-point]\n", "engine"),
        ("[box]\npacking_fraction = 0.1\n", "engine.ed"),
    ] {
        let text = COMPARISON.replacen(without, "", 1);
        let error = read(&text, &[]).expect_err(without);
        let refusal = error.refusal().expect("a refusal");
        let volume = key == "engine.ed" && refusal.key == "gas.volume";
        assert!(refusal.key == key || volume, "{without}: {error}");
    }
}

#[test]
fn places_are_lines_arguments_and_sweeps() {
    let text = COMPARISON.replace("0.9", "1.9");
    let error = read(&text, &[]).expect_err("1.9");
    assert!(
        error
            .to_string()
            .starts_with("case.toml:6:15: gas.restitution = 1.9"),
        "{error}"
    );
    let report = error.report(false);
    assert!(
        report.contains("--> case.toml:6:15") && report.contains("^^^"),
        "{report}"
    );

    let error = read(COMPARISON, &["gas.restitution=1.9"]).expect_err("1.9");
    assert!(
        error.to_string().starts_with("--set gas.restitution=1.9: "),
        "{error}"
    );

    // A refused override is named with its argument, not with the tables beside the key.
    let argument = "engine.dsmc-enskogg.displacement=false";
    let error = read(COMPARISON, &[argument]).expect_err("no engine");
    let place = format!("--set {argument}: unknown key engine.dsmc-enskogg");
    assert!(error.to_string().starts_with(&place), "{error}");

    let sweep = format!("{COMPARISON}[[sweep]]\n\"gas.restitution\" = [0.9, 1.9]\n");
    let error = read(&sweep, &[]).expect_err("1.9");
    assert!(
        error
            .to_string()
            .starts_with("case.toml:14:27: in a sweep, "),
        "{error}"
    );

    let error = read("\u{feff}format = 2\ntitle = [", &[]).expect_err("not TOML");
    assert!(error.to_string().starts_with("case.toml:2:"), "{error}");

    let twice = COMPARISON.replace("number = 1000", "number = 1000\nnumber = 2000");
    let error = read(&twice, &[]).expect_err("twice").to_string();
    assert!(error.starts_with("case.toml:6:1: "), "{error}");
    assert!(error.contains("number is there twice"), "{error}");

    let file = read(COMPARISON, &[]).expect("a case");
    let error = file.points[0].refuse("run.until", "less");
    assert!(
        error
            .to_string()
            .starts_with("case.toml:10:9: run.until = 10 is refused; the rule: less"),
        "{error}"
    );
}

#[test]
fn whole_numbers_may_have_exponents() {
    let set = [
        "gas.number=1e3",
        "replicas=3.0",
        "seed=1e5",
        "measure.snapshots.times=[0]",
    ];
    let case = &read(COMPARISON, &set).expect("a case").points[0].case;
    assert_eq!(
        (case.gas.number, case.replicas, case.seed),
        (Some(1000), 3, 100_000)
    );
    let text = COMPARISON.replace("format = 2", "format = 2.0");
    assert!(read(&text, &[]).is_ok());
    assert!(read(&format!("\u{feff}{COMPARISON}"), &[]).is_ok());
}

#[test]
fn overrides_reach_elements() {
    let set = [
        "species.2.number=60",
        "inflow.1.velocity=[2, 0]",
        "obstacle.1.circle.radius=3",
        "species.3.number=7",
    ];
    let case = &read(FLOW, &set).expect("a case").points[0].case;
    assert_eq!(case.species[1].number, Some(60));
    assert_eq!(case.species[2].number, Some(7));
    assert_eq!(case.inflow[0].velocity, [2.0, 0.0]);
    for bad in [
        "",
        "until",
        "=3",
        "run..until=3",
        "run.until=",
        "title=\"open",
        "a b=1",
        "format=2",
        "sweep=[]",
        "title=a\nb=2",
        "a.a.a.a.a.a.a.a.a=1",
    ] {
        let error = read(FLOW, &[bad]).expect_err(bad);
        assert!(error.to_string().starts_with("--set "), "{error}");
    }
}

/// Reads a comparison with more lines.
fn comparison_with(block: &str) -> Result<CaseFile, CaseError> {
    read(&format!("{COMPARISON}{block}"), &[])
}

#[test]
fn sweeps_are_products_of_lists_and_ranges() {
    let names = |block: &str| {
        let file = comparison_with(block).unwrap_or_else(|error| panic!("{error}"));
        let names = file.points.into_iter().map(|point| point.name);
        names.collect::<Vec<_>>()
    };
    assert_eq!(
        names(
            "[[sweep]]\n\"gas.restitution\" = [0.8, 0.9]\n\"box.packing_fraction\" = [0.1, 0.2]\n"
        ),
        [
            "packing_fraction=0.1,restitution=0.8",
            "packing_fraction=0.1,restitution=0.9",
            "packing_fraction=0.2,restitution=0.8",
            "packing_fraction=0.2,restitution=0.9"
        ]
    );
    assert_eq!(
        names("[[sweep]]\n\"gas.restitution\" = { from = 0.1, to = 0.4, points = 4 }\n"),
        [
            "restitution=0.1",
            "restitution=0.2",
            "restitution=0.3",
            "restitution=0.4"
        ]
    );
    assert_eq!(
        names("[[sweep]]\n\"gas.number\" = { from = 100, to = 10000, points = 4, log = true }\n"),
        ["number=100", "number=464", "number=2154", "number=10000"]
    );
    assert_eq!(
        names("[[sweep]]\n\"gas.restitution\" = { from = 0.1, to = 0.45, step = 0.1 }\n"),
        [
            "restitution=0.1",
            "restitution=0.2",
            "restitution=0.3",
            "restitution=0.4"
        ]
    );
    assert_eq!(
        names("[[sweep]]\n\"gas.restitution\" = { from = 0.9, to = 0.6, step = -0.15 }\n"),
        ["restitution=0.9", "restitution=0.75", "restitution=0.6"]
    );
    assert_eq!(
        names("[[sweep]]\n\"gas.number\" = { from = 100, to = 1600, step = 2, log = true }\n"),
        [
            "number=100",
            "number=200",
            "number=400",
            "number=800",
            "number=1600"
        ]
    );
    let text = format!("{COMPARISON}[[sweep]]\n\"gas.restitution\" = [0.8, 0.9]\n");
    let fixed = read(&text, &["gas.restitution=0.7"]).expect("a case");
    assert_eq!((fixed.points.len(), fixed.points[0].name.as_str()), (1, ""));
}

#[test]
fn sweeps_that_are_none_are_refused() {
    for (block, words) in [
        (
            "[[sweep]]\n\"gas.restitution\" = { from = 0.1, to = 0.4, step = -0.1 }\n",
            "it is negative where `to` is less",
        ),
        (
            "[[sweep]]\n\"gas.restitution\" = { from = 0.1, to = 0.4, step = 0 }\n",
            "it is negative where `to` is less",
        ),
        (
            "[[sweep]]\n\"gas.number\" = { from = 10, to = 40, step = 0.5, log = true }\n",
            "below 1 where `to` is less",
        ),
        (
            "[[sweep]]\n\"gas.restitution\" = { from = 0.1, to = 0.4, step = 1e-9 }\n",
            "at most 10000 points",
        ),
        (
            "[[sweep]]\n\"gas.restitution\" = { from = 0.1, to = 0.4 }\n",
            "either points or a step",
        ),
        (
            "[[sweep]]\n\"gas.restitution\" = { from = 0.1, to = 0.4, points = 4, step = 0.1 }\n",
            "either points or a step",
        ),
        ("[[sweep]]\n", "at least one quoted dotted key"),
        (
            "[[sweep]]\n\"gas.restitution\" = []\n",
            "a list of 1 to 10000",
        ),
        (
            "[[sweep]]\n\"gas.restitution\" = 3\n",
            "a table with the keys",
        ),
        (
            "[[sweep]]\n\"gas.restitution\" = [0.9, 0.9]\n",
            "the same case as the point restitution=0.9",
        ),
        ("[[sweep]]\n\"format\" = [2]\n", "any key but format"),
        (
            "[[sweep]]\n\"gas.restitution\" = { from = 0, to = 1, points = 3, log = true }\n",
            "above 0",
        ),
        (
            "[[sweep]]\n\"seed\" = { from = 1, to = 9999, points = 9999 }\n\"replicas\" = [1, 2]\n",
            "at most 10000 points",
        ),
        (
            "[[sweep]]\n\"gas\" = [1]\n\"gas.number\" = [3]\n",
            "already sweeps",
        ),
    ] {
        let error = comparison_with(block).expect_err(block);
        assert!(error.to_string().contains(words), "{block}: {error}");
    }
}

#[test]
fn an_earlier_end_cuts_times() {
    let text = format!(
        "{COMPARISON}[measure.snapshots]\ntimes = [0, 2, 10]\n[measure.impact_parameters]\nwindows = [[0, 1], [1, 5], [5, 10]]\n"
    );
    let file = read(&text, &["run.until=3"]).expect("a case");
    let measure = &file.points[0].case.measure;
    assert_eq!(measure["snapshots"]["times"].to_string(), "[0, 2, 3.0]");
    assert_eq!(
        measure["impact_parameters"]["windows"].to_string(),
        "[[0, 1], [1, 3.0]]"
    );
}

#[test]
fn cases_of_another_format_are_refused() {
    for (text, words) in [
        ("title = \"x\"\n", "format is missing: write `format = 2`"),
        ("format = 1\n", "this program reads format 2"),
        ("format = 3\n", "this program reads format 2"),
    ] {
        let message = read(text, &[]).expect_err("another format").to_string();
        assert!(message.contains(words), "{message}");
    }
}

/// Every key that was renamed is answered with its new name, in the table where it stood.
#[test]
fn renamed_keys_say_their_new_names() {
    for (setting, new) in [
        ("sticking={}", "aggregation"),
        ("continuous={}", "polydisperse"),
        ("gas.inertia=0.5", "reduced_inertia"),
        (
            "gas.contact_values=dense",
            "pair_correlation, \"boltzmann\" or \"enskog\"",
        ),
        ("box.critical_lengths=2", "width_over_critical_length"),
        (
            "obstacle=[{ disc = { centre = [1, 1], radius = 0.5 } }]",
            "circle",
        ),
        ("engine.dsmc-enskog.neighbourhood=3", "density_window"),
        (
            "engine.dsmc-enskog.largest_contact_value=50",
            "max_contact_value",
        ),
        (
            "engine.dsmc-enskog.steps_per_crossing=8",
            "steps_per_cell_crossing",
        ),
        ("engine.dsmc-enskog.walls_act_on=centre", "wall_contact"),
        ("engine.dsmc-enskog.copies=coherent", "simulator_start"),
        ("verdict.false_alarm=0.01", "family_wise_error_rate"),
    ] {
        let message = read(COMPARISON, &[setting])
            .expect_err("an old key")
            .to_string();
        let question = format!("did you mean {new}?");
        assert!(message.contains(&question), "{setting}: {message}");
    }
}

#[test]
fn measures_are_checked_by_their_schemas() {
    #[derive(schemars::JsonSchema)]
    #[schemars(deny_unknown_fields)]
    #[expect(dead_code, reason = "only its schema is used")]
    struct Snapshots {
        #[schemars(range(min = 1, max = 9))]
        bins: Option<u64>,
    }
    let format = Format::new(&[("snapshots", schema_of::<Snapshots>())]);
    let read = |set: &str| format.from_text(Path::new("case.toml"), COMPARISON, &[set.to_owned()]);
    assert!(read("measure.snapshots.bins=3").is_ok());
    for (set, words) in [
        ("measure.snapshot={}", "did you mean snapshots?"),
        ("measure.snapshots.bin=3", "did you mean bins?"),
        ("measure.snapshots.bins=30", "from 1 to 9"),
    ] {
        let message = read(set).expect_err(set).to_string();
        assert!(message.contains(words), "{message}");
    }
    let whole = read("measure.snapshots.bins=3e0").expect("a case");
    assert_eq!(
        whole.points[0].case.measure["snapshots"]["bins"].as_integer(),
        Some(3)
    );
}

/// Collects all dotted keys of a schema, with 1 for the elements of lists.
fn keys(schema: &serde_json::Value, path: &str, all: &mut Vec<String>) {
    if !path.is_empty() {
        all.push(path.to_owned());
    }
    for choice in ["anyOf", "oneOf"]
        .iter()
        .filter_map(|one| schema[one].as_array())
        .flatten()
    {
        keys(choice, path, all);
    }
    let items = &schema["items"];
    if items.is_object() && !path.is_empty() {
        keys(items, &format!("{path}.1"), all);
    }
    for (key, inner) in schema["properties"].as_object().into_iter().flatten() {
        let path = if path.is_empty() {
            key.clone()
        } else {
            format!("{path}.{key}")
        };
        keys(inner, &path, all);
    }
}

const ODD: &[&str] = &[
    "0",
    "-1",
    "1e5",
    "1e308",
    "5e-324",
    "inf",
    "-inf",
    "nan",
    "9223372036854775807",
    "1e19",
    "true",
    "word",
    "\"\"",
    "[]",
    "[[]]",
    "{}",
    "[0, 0]",
    "[1e99, 1e99]",
    "[{}]",
    "1979-05-27",
    "2",
    "3",
    "0.5",
    "1",
    "\"\\u0000\"",
    "file",
    "\"1%\"",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(1872), ..ProptestConfig::default() })]

    #[test]
    fn no_key_at_no_value_panics(base in 0_usize..3, picks in prop::collection::vec((any::<prop::sample::Index>(), 0..ODD.len()), 1..4)) {
        let mut all = Vec::new();
        keys(&stosszahl_case::schema(), "", &mut all);
        let set: Vec<String> = picks.iter().map(|(key, value)| format!("{}={}", key.get(&all), ODD[*value])).collect();
        let text = [COMPARISON, FLOW, HOMOGENEOUS][base];
        if let Err(error) = CaseFile::from_text(Path::new("case.toml"), text, &set) {
            prop_assert!(!error.report(false).is_empty());
            prop_assert!(!error.to_string().contains("format 2"));
        }
    }

    #[test]
    fn no_text_panics(cut in 0_usize..400, junk in "\\PC{0,12}") {
        let text = FLOW;
        let cut = cut.min(text.len());
        let broken = format!("{}{junk}{}", &text[..cut], &text[cut..]);
        if let Err(error) = CaseFile::from_text(Path::new("case.toml"), &broken, &[]) {
            prop_assert!(!error.report(false).is_empty());
        }
    }
}
