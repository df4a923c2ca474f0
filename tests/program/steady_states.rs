//! Gases that reach a steady state, and the pressure tensor, against theory and against each other.

use std::fs;

use crate::support::program::{Columns, TestFolder, bundled};

/// Temperature of the Delta model in exact dynamics and in Monte Carlo against Enskog's theory.
///
/// Theory expands velocities to the fifth Sonine order and is right to 0.2 %, by an independent
/// Monte Carlo of the Boltzmann equation (T/(m Delta^2) = 81.99 at r = 0.9). N - 1 in place of N
/// free velocities makes 0.1 %. At packing 0.005 broken chaos is below 0.1 %. For all three 0.5 %
/// is allowed.
///
/// The statistical tolerance is the measured standard error times 5.41, Student's t with seven
/// degrees of freedom at a false alarm of 1e-3. More than 2 % in all fails too, because a wrong
/// cumulant (1.6 %) would pass.
#[test]
fn delta_model_settles_at_the_temperature_of_theory() {
    let work = TestFolder::new(&fs::read_to_string(bundled("delta-model")).expect("a case"));
    work.done("run case.toml --out out");
    let table = Columns::read(&work.path("out"), "steady_state");
    let column = |name| table.numbers(name);
    let (found, errors) = (column("temperature_ratio"), column("temperature_ratio_se"));
    let theory = column("temperature_ratio_theory");
    for engine in 0..2 {
        // Two last quarters; each is 60 collisions long, some twelve relaxation times.
        let late = [4 * engine + 2, 4 * engine + 3];
        let mean: f64 = late.iter().map(|&row| 0.5 * found[row] / theory[row]).sum();
        let squares = late
            .iter()
            .map(|&row| (0.5 * errors[row] / theory[row]).powi(2));
        let error = 1.1 * squares.sum::<f64>().sqrt();
        println!("engine {engine}: T/T_theory = {mean:.4} ± {error:.4}");
        let allowed = 0.005 + 5.41 * error;
        assert!((mean - 1.0).abs() < allowed, "{mean} ± {error}");
        assert!(allowed < 0.02, "the error bar {error} is too wide");
    }
}

/// Pressure of elastic disks: exact dynamics and contact points find Enskog's pressure with the
/// contact value of the equation of state, and point particles that of the ideal gas. The diagonal
/// is isotropic and the other elements are zero.
///
/// The contact value is right to 0.1 % of the pressure at packing 0.25, that of a periodic box of
/// 400 disks to 1/N = 0.25 %. Contact points with four simulators lose some 0.5 % of their
/// collisions. Allowed for that are 1 %, and Student's t with seven degrees of freedom at a false
/// alarm of 1e-3, 5.41, times the measured standard error. With more than 5 % in all a missing half
/// of the collisional part would still fail, so that is the bound of the error bar.
#[test]
fn pressure_of_elastic_disks_is_that_of_the_equation_of_state() {
    let work = TestFolder::new(
        r#"# Which pressure have elastic disks?
format = 2
title = "pressure of elastic disks"
seed = 3
replicas = 8
[gas]
number = 400
[box]
packing_fraction = 0.25
[run]
until = 60
[engine.ed]
[engine.dsmc-contact-point]
simulators_per_particle = 4
[engine.dsmc-boltzmann]
[measure.stress]
"#,
    );
    work.done("run case.toml --out out");
    let table = Columns::read(&work.path("out"), "stress");
    let (names, engines) = (table.texts("quantity"), table.texts("engine"));
    let [total, error, theory] =
        ["total", "total_se", "total_theory"].map(|name| table.numbers(name));
    let collisional = table.numbers("collisional");
    for row in 0..total.len() {
        let (name, engine) = (&names[row], &engines[row]);
        println!(
            "{engine} {name}: {} ± {}, theory {}",
            total[row], error[row], theory[row]
        );
        let scale = if engine == "dsmc-boltzmann" {
            1.0
        } else {
            1.79
        };
        let allowed = 0.01 * scale + 5.41 * error[row];
        assert!(
            (total[row] - theory[row]).abs() < allowed,
            "{engine} {name}"
        );
        assert!(
            allowed < 0.05 * scale + 0.05,
            "{engine} {name}: the error bar is too wide"
        );
        if name == "pressure" && engine != "dsmc-boltzmann" {
            assert!(
                (collisional[row] - 0.79).abs() < 0.03,
                "{engine}: {}",
                collisional[row]
            );
        }
    }
}

/// Compares the normal stress difference and shear stress over n T of a dilute sheared gas, from
/// exact disks, Boltzmann and Enskog schemes.
///
/// The known values are those of an independent Boltzmann Monte Carlo simulation, with an error of
/// some 0.5 %. At packing 0.005 Enskog's corrections are below 1 %, and 400 disks lose 1/N to their
/// total momentum. For all that 0.01 n T is allowed.
///
/// The statistical tolerance is the measured standard error times 5.41, Student's t with seven
/// degrees of freedom at a false alarm of 1e-3. A total tolerance above 0.045 n T fails too,
/// because that is half of the way to the stress of restitution 0.9 (0.295 instead of 0.387).
#[test]
fn dilute_sheared_gases_have_one_stress() {
    let work = TestFolder::new(
        r#"# Which stress has a dilute sheared gas?
format = 2
title = "dilute shear"
seed = 5
replicas = 8
[gas]
number = 400
restitution = 0.8
[box]
packing_fraction = 0.005
# 0.49 nu_0 at temperature one, nu_0 = 2 n d sqrt(pi T/m).
shear_rate = 0.01106
[run]
until = 200
[engine.ed]
[engine.dsmc-boltzmann]
simulators_per_particle = 4
[engine.dsmc-enskog]
simulators_per_particle = 4
[measure.stress]
"#,
    );
    work.done("run case.toml --out out");
    let table = Columns::read(&work.path("out"), "stress");
    let (engines, quantities) = (table.texts("engine"), table.texts("quantity"));
    let (found, errors) = (table.numbers("total"), table.numbers("total_se"));
    for (quantity, known) in [("normal_stress_difference", 1.184 - 0.816), ("xy", -0.387)] {
        let rows: Vec<usize> = (0..found.len())
            .filter(|&row| quantities[row] == quantity)
            .collect();
        assert_eq!(rows.len(), 3);
        for row in rows {
            let (value, error) = (found[row], errors[row]);
            println!("{} {quantity}: {value:.4} ± {error:.4}", engines[row]);
            let allowed = 0.01 + 5.41 * error;
            assert!((value - known).abs() < allowed, "{value} ± {error}");
            assert!(allowed < 0.045, "the error bar {error} is too wide");
        }
    }
}

/// The lattice of snapshots leads to the image above, which a shear flow has displaced by `a L_y t`,
/// folded into the width of the box.
#[test]
fn snapshots_of_a_sheared_gas_have_its_lattice() {
    let work = TestFolder::new(
        r#"# Where is the image above?
format = 2
title = "lattice of a sheared gas"
seed = 3
[gas]
number = 50
restitution = 0.8
[box]
size = [12.0, 9.0]
shear_rate = 0.5
[run]
time_unit = "case"
until = 4
[engine.ed]
[engine.dsmc-boltzmann]
[measure.snapshots]
times = [0, 4]
"#,
    );
    work.done("run case.toml --out out");
    for engine in ["ed", "dsmc-boltzmann"] {
        // 0.5 * 9 * 4 = 18 is one width and a half.
        for (number, offset) in [(0, 0.0), (1, 6.0)] {
            let text = work.text(&format!("out/snapshots/{engine}-{number}.xyz"));
            let lattice = text.split('"').nth(1).expect("a lattice");
            let numbers: Vec<f64> = lattice
                .split(' ')
                .map(|one| one.parse().expect("a number"))
                .collect();
            assert_eq!(numbers[..3], [12.0, 0.0, 0.0], "{engine}: {lattice}");
            assert_eq!(numbers[4..6], [9.0, 0.0], "{engine}: {lattice}");
            // The product is a few roundings away from 18.
            assert!((numbers[3] - offset).abs() < 1e-13, "{engine}: {lattice}");
        }
    }
}
