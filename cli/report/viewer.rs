//! The particles of the snapshots, packed for the viewer inside the page.
//!
//! A disk takes five bytes: two numbers of sixteen bits for the position in units of the sides, and eight bits for the
//! direction of the velocity; a sixth byte holds the radius where radii differ. Base64 adds a third. The drawing is
//! done by the plain script in `viewer.js`, because a library for it would weigh more than the particles.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::figures::{engine_name, engines, same, spread};
use super::read::{self, Particles};
use super::{ReportError, Results};
use crate::manifest::Snapshot;

/// The script of the viewer.
pub(crate) const SCRIPT: &str = include_str!("viewer.js");

/// What the section of the snapshots shows.
#[derive(Debug, Default)]
pub(crate) struct Frames {
    /// The data of the viewer as JSON that may stand inside a script element; empty without frames.
    pub data: String,
    /// Times that are shown, `t/t0`.
    pub times: Vec<f64>,
    /// Times of which snapshots exist.
    pub available: usize,
    /// Snapshot files that the manifest names but the folder lacks.
    pub missing: Vec<String>,
}

/// Reads and packs snapshots, as many times as fit into `budget` bytes.
pub(crate) fn frames(
    folder: &Path,
    results: &Results,
    budget: usize,
) -> Result<Frames, ReportError> {
    let mut missing = Vec::new();
    let mut present: Vec<(&Snapshot, usize)> = Vec::new();
    for snapshot in &results.manifest.snapshots {
        match read::particle_count(&folder.join(&snapshot.file))? {
            Some(count) => present.push((snapshot, count)),
            None => missing.push(snapshot.file.clone()),
        }
    }
    let names = engines(present.iter().map(|(snapshot, _)| &snapshot.engine));
    let times = super::figures::distinct(present.iter().map(|(snapshot, _)| snapshot.time_over_t0));
    let mut packed: Vec<(usize, usize, f64, String)> = Vec::new();
    let mut shown = Vec::new();
    // Six bytes for each disk in base64, and a little for the names of the fields.
    let size_at = |time: f64| -> usize {
        let at_time = present
            .iter()
            .filter(|(snapshot, _)| same(snapshot.time_over_t0, time));
        at_time.fold(0, |sum, (_, count)| {
            count
                .saturating_mul(8)
                .saturating_add(200)
                .saturating_add(sum)
        })
    };
    for most in (1..=times.len()).rev() {
        let some = spread(&times, most);
        if some
            .iter()
            .fold(0, |sum: usize, time| sum.saturating_add(size_at(*time)))
            <= budget
        {
            shown = some;
            break;
        }
    }
    for (place, time) in shown.iter().enumerate() {
        for (column, name) in names.iter().enumerate() {
            let found = present.iter().find(|(snapshot, _)| {
                snapshot.engine == *name && same(snapshot.time_over_t0, *time)
            });
            if let Some((snapshot, _)) = found {
                let particles = read::snapshot(&folder.join(&snapshot.file))?;
                packed.push((place, column, *time, pack(&particles).to_string()));
            }
        }
    }
    let mut frames = Frames {
        data: String::new(),
        times: shown,
        available: times.len(),
        missing,
    };
    if !packed.is_empty() {
        frames.data = assemble(&frames.times, &names, &packed);
    }
    Ok(frames)
}

/// Puts the packed frames into one JSON text, a list of times of lists of engines.
fn assemble(times: &[f64], names: &[String], packed: &[(usize, usize, f64, String)]) -> String {
    let labels: Vec<String> = names.iter().map(|name| engine_name(name)).collect();
    let mut text = format!(
        "{{\"engines\":{},\"times\":{},\"frames\":[",
        json!(labels),
        json!(times)
    );
    for place in 0..times.len() {
        text.push_str(if place == 0 { "[" } else { ",[" });
        for column in 0..names.len() {
            let frame = packed.iter().find(|(p, c, ..)| (*p, *c) == (place, column));
            let comma = if column == 0 { "" } else { "," };
            let _ = write!(text, "{comma}{}", frame.map_or("null", |(.., frame)| frame));
        }
        text.push(']');
    }
    text.push_str("]}");
    // The text stands inside a script element, which a tag in a name must not close.
    text.replace('<', "\\u003c")
}

/// Packs one frame.
fn pack(particles: &Particles) -> Value {
    let [width, height] = particles.sides;
    let largest = particles
        .disks
        .iter()
        .map(|disk| disk.radius)
        .fold(0.0, f64::max);
    let equal = particles
        .disks
        .iter()
        .all(|disk| same(disk.radius, largest));
    let mut places = Vec::with_capacity(4 * particles.disks.len());
    let mut hues = Vec::with_capacity(particles.disks.len());
    let mut radii = Vec::new();
    for disk in &particles.disks {
        for axis in 0..2 {
            let fraction = (disk.position[axis] / particles.sides[axis]).rem_euclid(1.0);
            // Rounding up to one is the other end of the period, which is zero.
            let place = ((fraction * 65536.0).round() as u32 % 65536) as u16;
            places.extend_from_slice(&place.to_le_bytes());
        }
        let turn = (disk.velocity[1].atan2(disk.velocity[0]) / TAU).rem_euclid(1.0);
        hues.push(((turn * 256.0).round() as u32 % 256) as u8);
        if !equal {
            radii.push((disk.radius / largest * 255.0).round() as u8);
        }
    }
    json!({
        "w": width, "h": height, "r": largest,
        "p": STANDARD.encode(places), "v": STANDARD.encode(hues), "s": STANDARD.encode(radii),
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at what it cannot read")]
mod tests {
    use super::*;
    use crate::report::read::Disk;

    #[test]
    fn a_disk_takes_five_bytes_and_returns_to_its_place() {
        let disk = Disk {
            position: [2.5, 10.0],
            velocity: [0.0, 1.0],
            radius: 0.5,
        };
        let frame = pack(&Particles {
            sides: [10.0, 10.0],
            disks: vec![disk],
        });
        let places = STANDARD.decode(frame["p"].as_str().unwrap()).unwrap();
        assert_eq!(
            places,
            [0x00, 0x40, 0, 0],
            "a quarter of the side, and the period itself"
        );
        assert_eq!(
            STANDARD.decode(frame["v"].as_str().unwrap()).unwrap(),
            [64],
            "a quarter turn"
        );
        assert_eq!(frame["s"], "");
        assert_eq!(frame["r"], 0.5);
    }

    #[test]
    fn a_name_cannot_close_the_script() {
        let text = assemble(
            &[1.0],
            &["</script>".to_owned()],
            &[(0, 0, 1.0, "{}".to_owned())],
        );
        assert!(!text.contains('<'));
        let read: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(read["engines"][0], "</script>");
    }
}
