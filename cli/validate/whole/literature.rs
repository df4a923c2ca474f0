//! Closed forms against printed numbers.

use std::time::Instant;

use stosszahl_analysis::statistics::Estimate;
use stosszahl_model::{kinetic, transport};

use crate::validate::table::{Place, Row};

/// A printed number: what it is, packing fraction, its value, how far it is rounded, and what the program says.
struct Printed {
    what: &'static str,
    packing: f64,
    value: f64,
    rounding: f64,
    found: f64,
}

/// 1/t0 of Luding, Müller & McNamara (1998): d = 1 mm, packing 0.25, r = 0.8 and a root mean squared speed of 0.2047 m/s \[1/s\].
fn luding() -> f64 {
    let (diameter, speed) = (0.001, 0.2047 / 2.0_f64.sqrt());
    let reduced = kinetic::haff_time(0.25, 0.8, kinetic::contact_value(0.25));
    speed / (diameter * reduced)
}

/// All of them.
pub(super) fn all() -> Vec<Row> {
    let began = Instant::now();
    let length = |packing: f64, r: f64| {
        transport::critical_length(packing, kinetic::contact_value(packing), r)
    };
    let list = [
        Printed {
            // Their speed is itself rounded to four digits, which moves 1/t0 by 0.15 %.
            what: "1/t0 in 1/s (Luding, Müller & McNamara 1998)",
            packing: 0.25,
            value: 23.24,
            rounding: 0.04,
            found: luding(),
        },
        Printed {
            what: "critical length of shear modes in d, r = 0.8, Enskog theory in first Sonine order",
            packing: 0.25,
            value: 17.3,
            rounding: 0.09,
            found: length(0.25, 0.8),
        },
        Printed {
            what: "contact value (Henderson 1975)",
            packing: 0.25,
            value: 1.5833,
            rounding: 0.0001,
            found: kinetic::henderson(0.25),
        },
        Printed {
            what: "a2 of disks, r = 0.8 (van Noije & Ernst 1998)",
            packing: 0.0,
            value: -0.0219,
            rounding: 0.0001,
            found: kinetic::fourth_cumulant(2, 0.8),
        },
    ];
    let rows = list.into_iter().map(|printed| {
        let here = Place {
            part: "literature",
            scheme: "theory".into(),
            setting: "closed form".into(),
            packing: printed.packing,
            seconds: began.elapsed().as_secs_f64(),
            default: true,
        };
        let found = Estimate {
            value: printed.found,
            standard_error: Some(0.0),
            replicas: 1,
        };
        here.row(printed.what, printed.value, found, Some(printed.rounding))
    });
    rows.collect()
}
