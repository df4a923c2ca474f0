//! Flows between walls and around obstacles: free volume, cells and errors, for gases with known
//! values.

use std::f64::consts::PI;
use std::path::Path;

use stosszahl_analysis::replicas::quantile;
use stosszahl_case::CaseFile;
use stosszahl_model::Interrupt;
use stosszahl_model::random::Streams;
use stosszahl_results::{Table, TableCell, VerdictKind, VerdictText};

use crate::check;
use crate::control::Control;
use crate::engine_run::EngineRun;
use crate::measure::{CompletedRun, Measure, ReplicaRecords};
use crate::plan::{CasePlan, PlanError};
use crate::start::placed;

fn planned(text: &str) -> Result<CasePlan, PlanError> {
    let text = format!("format = 2\ntitle = \"a flow\"\n{text}");
    let file = CaseFile::from_text(Path::new("case.toml"), &text, &[]).expect("a case");
    CasePlan::new(&file.points[0].case, Path::new(""))
}

pub(crate) fn plan(text: &str) -> CasePlan {
    planned(text).expect("a plan")
}

/// Value of a quantity that `check` lists.
fn derived(plan: &CasePlan, name: &str) -> f64 {
    let all = plan.derived();
    let found = all.iter().find(|one| one.name == name);
    found.unwrap_or_else(|| panic!("no {name}")).value
}

/// Tables and verdicts of a measure after runs of all engines and replicas.
pub(crate) fn measured(plan: &CasePlan, name: &str) -> (Vec<Table>, Vec<VerdictText>) {
    let measures: Vec<&dyn Measure> = (check::chosen(plan).expect("measures").into_iter())
        .filter(|measure| measure.name() == name)
        .collect();
    let never = Interrupt::default();
    let one = |engine, replica| {
        let streams = Streams::new(plan.case.seed, replica);
        let (start, ..) = placed(plan, 0, streams, &never).expect("a start");
        let part = EngineRun {
            plan,
            engine,
            measures: &measures,
            replica,
            start: Some(&start),
        };
        let control = Control::new(None, 1e9, &never, &|_, _| {});
        part.run_engine(&control).expect("a run")
    };
    let engines = plan.engines.iter();
    let finished: Vec<Vec<CompletedRun>> = engines
        .map(|engine| {
            (0..plan.case.replicas)
                .map(|replica| one(engine, replica))
                .collect()
        })
        .collect();
    let runs = ReplicaRecords {
        measure: 0,
        level: 0.01,
        finished: &finished,
    };
    let tables = measures[0].result_tables(plan, &runs);
    let verdicts = measures[0].result_verdicts(plan, &runs, &tables);
    (tables, verdicts)
}

/// Numbers in a column of a table.
pub(crate) fn column(table: &Table, name: &str) -> Vec<f64> {
    let at = table
        .find_column(name)
        .unwrap_or_else(|| panic!("no {name}"));
    let number = |row: &Vec<TableCell>| match row[at] {
        TableCell::Number(number) => number,
        TableCell::Count(count) => count as f64,
        _ => f64::NAN,
    };
    table.rows.iter().map(number).collect()
}

/// Case with four disks that cover half of the box.
const DISCS: &str = "\
    replicas = 2\n[gas]\nnumber = 2000\ndiameter = 0.02\nrestitution = 1\n[box]\nsize = [40, 40]\n\
    [[obstacle]]\ncircle = { centre = [10, 10], radius = 8 }\n[[obstacle]]\ncircle = { centre = [30, 10], radius = 8 }\n\
    [[obstacle]]\ncircle = { centre = [10, 30], radius = 8 }\n[[obstacle]]\ncircle = { centre = [30, 30], radius = 8 }\n\
    [run]\nuntil = 400\nsamples = 400\n[engine.ENGINE]\n";

/// Density, free path and collisions of a dilute gas follow from the area open to its centres,
/// 1600 - 4 pi (8 + r)^2; its packing fraction from the area that no disk covers. Areas are
/// accurate to 1e-9 of the box.
#[test]
fn a_gas_among_obstacles_has_their_free_area() {
    let close = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-7, "{found} {expected}");
    };
    // Exact disks stay a radius away from obstacles, point particles do not.
    for (engine, radius) in [("ed", 0.01), ("dsmc-boltzmann", 0.0)] {
        let plan = plan(&DISCS.replace("ENGINE", engine));
        let free = 1600.0 - 4.0 * PI * (8.0 + radius) * (8.0 + radius);
        let density = 2000.0 / free;
        close(derived(&plan, "volume"), 1600.0);
        close(derived(&plan, "free_volume"), free);
        close(derived(&plan, "number_density"), density);
        let path = 1.0 / (8.0_f64.sqrt() * 0.02 * density);
        close(derived(&plan, "mean_free_path"), path);
        let collisions = 2.0 * PI.sqrt() * density * 0.02 * 400.0;
        close(
            derived(&plan, "expected_collisions_per_particle"),
            collisions,
        );
        let packing = 2000.0 * PI * 1e-4 / (1600.0 - 256.0 * PI);
        close(derived(&plan, "packing_fraction"), packing);
        let mean_free = DISCS.replace("until = 400", "until = 10\ntime_unit = \"mean-free-time\"");
        let by_path = self::plan(&mean_free.replace("ENGINE", engine));
        close(by_path.clock.mean_free_time, 400.0 / collisions);
        close(derived(&by_path, "unit_of_time"), 400.0 / collisions);
        if engine == "ed" {
            continue;
        }
        // A diameter derived from the free path is that of the same gas.
        for (act, radius) in [("", 0.0), ("wall_contact = \"radius\"\n", 0.01)] {
            let free = 1600.0 - 4.0 * PI * (8.0 + radius) * (8.0 + radius);
            let path = free / (8.0_f64.sqrt() * 0.02 * 2000.0);
            let by_length = DISCS.replace("diameter = 0.02", &format!("mean_free_path = {path}"));
            let by_length = format!("{}{act}", by_length.replace("ENGINE", engine));
            close(2.0 * self::plan(&by_length).mean_radius(), 0.02);
        }
    }
}

/// A packing fraction refers to the area that obstacles leave: the box grows by the area they
/// cover.
#[test]
fn a_packing_fraction_is_of_what_obstacles_leave() {
    let text = "[gas]\nnumber = 600\nrestitution = 1\n[box]\npacking_fraction = 0.1\naspect_ratio = 2\n\
                [[obstacle]]\ncircle = { centre = [10, 10], radius = 4 }\n\
                [[obstacle]]\npolygon = [[10, 20], [20, 20], [20, 24], [10, 24]]\n[run]\nuntil = 1\n[engine.ed]\n";
    let flat = plan(text);
    let [width, height, _] = flat.gas.lengths;
    let wanted = 600.0 * PI / 4.0 / 0.1 + 16.0 * PI + 40.0;
    assert!((width * height / wanted - 1.0).abs() < 1e-8);
    assert!((height / width - 2.0).abs() < 1e-12);
    assert_eq!(flat.gas.packing_fraction, 0.1);
    // Obstacles may overlap one another, and cover the whole box.
    let twice = text.replace(
        "[[obstacle]]\npolygon",
        "[[obstacle]]\ncircle = { centre = [10, 10], radius = 3 }\n[[obstacle]]\npolygon",
    );
    assert!((plan(&twice).gas.volume / flat.gas.volume - 1.0).abs() < 1e-8);
    let full = text
        .replace(
            "packing_fraction = 0.1\naspect_ratio = 2",
            "size = [30, 30]",
        )
        .replace(
            "[[10, 20], [20, 20], [20, 24], [10, 24]]",
            "[[0, 0], [30, 0], [30, 30], [0, 30]]",
        );
    let refused = planned(&full).expect_err("no room");
    assert_eq!(refused.key, "obstacle", "{refused}");
}

/// Particles of a region cover a fraction of its free area, here without a quarter of a disk in the
/// corner. Areas are accurate to 1e-9 of the region.
#[test]
fn a_region_has_the_packing_of_its_free_area() {
    let text = |region: &str| {
        format!(
            "[gas]\nnumber = 20\nrestitution = 1\n[box]\nsize = [30, 30]\n[[obstacle]]\ncircle = {{ centre = [10, 10], radius = 5 }}\n\
             [start]\nregion = {region}\n[run]\nuntil = 1\n[engine.ed]\n"
        )
    };
    let part = plan(&text("[[0, 0], [10, 10]]"));
    let found = part.packing_of_region().expect("a packing");
    let wanted = 20.0 * PI / 4.0 / (100.0 - 25.0 * PI / 4.0);
    assert!((found.expect("a region") / wanted - 1.0).abs() < 1e-8);
    let refused = planned(&text("[[8, 8], [12, 12]]")).expect_err("no room");
    assert_eq!(refused.key, "start.region", "{refused}");
    assert!(refused.found.contains("cover all of it"), "{refused}");
}

/// A dilute gas at rest among obstacles is uniform: each cell and row of the fields has the density
/// of the free area, and the pressure n T, within the measured errors. One of 24 cells and rows
/// exceeds its limit in one of 1000 tests.
#[test]
fn fields_among_obstacles_are_of_the_free_area() {
    let text = "replicas = 4\nseed = 3\n[gas]\nnumber = 600\ndiameter = 0.05\nrestitution = 1\n[box]\nsize = [20, 20]\n\
                [[obstacle]]\ncircle = { centre = [6, 6], radius = 5 }\n\
                [[obstacle]]\npolygon = [[11, 11], [19, 12], [14, 19]]\n\
                [run]\nuntil = 40\nsamples = 80\n[engine.ed]\n[measure.fields]\ncells = [4, 4]\n";
    let plan = plan(text);
    let (tables, _) = measured(&plan, "fields");
    let density = 600.0 / plan.gas.volume;
    // Computed by hand, without the corners of the polygon.
    let polygon = 0.5 * (8.0_f64 * 8.0 - 1.0 * 3.0);
    let around = 400.0 - PI * 5.025 * 5.025 - polygon;
    assert!(
        (plan.gas.volume / around - 1.0).abs() < 0.01,
        "{} {around}",
        plan.gas.volume
    );
    let mut judged = 0;
    for table in &tables {
        let [values, errors, parts] =
            ["number_density", "number_density_se", "parts"].map(|name| column(table, name));
        for ((value, error), parts) in values.into_iter().zip(errors).zip(parts) {
            let limit = quantile(1e-3 / 24.0, Some(parts as usize - 1)) * error;
            let off = (value - density).abs();
            assert!(
                off <= limit,
                "{}: {value} {density} {error} {parts}",
                table.name
            );
            assert!(parts < 8.0 || error < 0.3 * density, "{error} of {density}");
            judged += usize::from(parts >= 8.0);
        }
    }
    assert!(judged >= 16, "{judged} places with errors from many blocks");
    let pressures = column(&tables[1], "pressure");
    let temperatures = column(&tables[1], "temperature");
    let densities = column(&tables[1], "number_density");
    // Collisions add 1.57 packing fractions, some 0.6 %, known to a tenth of it.
    for place in 0..pressures.len() {
        let ratio = pressures[place] / (densities[place] * temperatures[place]);
        assert!((1.0..1.02).contains(&ratio), "{ratio}");
    }
}

/// Case of heat conduction between two walls.
const WALLS: &str = "replicas = 2\n[gas]\nnumber = 460\nrestitution = 1\n[box]\nsize = [60, 60]\n\
     [walls]\nleft = { temperature = 1 }\nright = { temperature = 4 }\n[run]\nuntil = 20\nsamples = 40\n";

/// Default cells of a flow are half a free path wide and hold ten simulators. Coarser ones are
/// named before the run, and make comparisons void.
#[test]
fn flows_resolve_their_free_path_or_say_so() {
    let fine = plan(&format!("{WALLS}[engine.dsmc-boltzmann]\n"));
    let width = derived(&fine, "dsmc_boltzmann_cell_size_over_mean_free_path");
    let simulators = derived(&fine, "dsmc_boltzmann_simulators_per_cell");
    // Whole numbers of cells make them up to a 43rd wider.
    assert!((0.48..0.52).contains(&width), "{width}");
    assert!((9.5..11.0).contains(&simulators), "{simulators}");
    assert_eq!(fine.notes.warnings, Vec::<String>::new());
    assert!(fine.numerical_error(&fine.engines[0]).is_none());
    // With more particles than simulators wanted, each particle has one simulator, in cells that
    // hold ten.
    let many = WALLS
        .replace("460", "4600000")
        .replace("60, 60", "6000, 6000");
    let many = plan(&format!("{many}[engine.dsmc-boltzmann]\n"));
    assert_eq!(many.engines[0].copies(), 1);
    assert!(derived(&many, "dsmc_boltzmann_simulators_per_cell") > 9.0);

    let coarse = "[engine.ed]\n[engine.dsmc-boltzmann]\nsimulators_per_particle = 1\n";
    let few =
        "[engine.ed]\n[engine.dsmc-boltzmann]\nsimulators_per_particle = 1\ncell_size = 1.4\n";
    for (engines, words, reason) in [
        (coarse, "mean free paths wide", "cells 3.6"),
        (few, "simulators per cell", "0.26"),
    ] {
        let plan = plan(&format!("{WALLS}{engines}"));
        let named = plan
            .notes
            .warnings
            .iter()
            .filter(|one| one.contains(words))
            .count();
        assert_eq!(named, 1, "{:?}", plan.notes.warnings);
        let said = plan.numerical_error(&plan.engines[1]).expect("a reason");
        assert!(said.contains(reason), "{said}");
        let (_, verdicts) = measured(&plan, "fields");
        let compared = verdicts
            .iter()
            .find(|one| one.topic.starts_with("density profile"));
        let compared = compared.expect("a comparison");
        assert_eq!(compared.kind, VerdictKind::Void, "{}", compared.sentence);
    }
}

/// Samples that 40 blocks do not divide fall into another number of blocks, which is reported; if
/// none divides them, `run.samples` is at fault.
#[test]
fn any_number_of_samples_has_its_blocks() {
    let text = |samples: u64| {
        let samples = format!("samples = {samples}\n");
        format!(
            "{}[engine.dsmc-boltzmann]\n",
            WALLS.replace("samples = 40\n", &samples)
        )
    };
    for (samples, blocks) in [(100, 50), (50, 50), (60, 30), (75, 25), (90, 45), (500, 50)] {
        let plan = plan(&text(samples));
        check::chosen(&plan).expect("measures");
        let told = format!("measure.fields.blocks = {blocks}:");
        let chosen = plan
            .notes
            .choices
            .iter()
            .filter(|one| one.starts_with(&told))
            .count();
        assert_eq!(chosen, 1, "{samples}: {:?}", plan.notes.choices);
    }
    let usual = plan(&text(400));
    assert!(!usual.notes.choices.iter().any(|one| one.contains("blocks")));
    let refused = planned(&text(326)).expect_err("no divisor");
    assert_eq!(refused.key, "run.samples");
    assert!(refused.allowed.contains("such as 360"), "{refused}");
    let own = plan(&format!("{}[measure.fields]\nblocks = 163\n", text(326)));
    check::chosen(&own).expect("measures");
}
