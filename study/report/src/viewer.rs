//! The particles of the snapshots, packed for the viewer inside the page.
//!
//! A disk takes five bytes: two numbers of sixteen bits for the position in units of the sides, and eight bits for the
//! direction of the velocity; a sixth byte holds the radius where radii differ. Base64 adds a third. The drawing is
//! done by the plain script in `viewer.js`, because a library for it would weigh more than the particles.

use std::f64::consts::TAU;
use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use stosszahl_model::initial::{self, StartFile};
use stosszahl_results::{Manifest, Snapshot, engine_rank, engine_title};

use crate::ReportError;
use crate::words::{number, spread};

/// The script of the viewer.
pub(crate) const SCRIPT: &str = include_str!("viewer.js");
/// Bytes of particles in a page.
const BUDGET: u64 = 10_000_000;

/// What the viewer shows.
pub(crate) struct Frames {
    /// JSON that may stand inside a script element; empty without frames.
    pub data: String,
    /// Times that are shown, and times of which there are snapshots.
    pub shown: usize,
    pub available: usize,
    /// Files that the folder lacks.
    pub missing: Vec<String>,
}

/// Reads and packs the snapshots of a folder, as many times as fit.
pub(crate) fn frames(folder: &Path, manifest: &Manifest) -> Result<Frames, ReportError> {
    let size = |one: &Snapshot| {
        folder
            .join(&one.file)
            .metadata()
            .ok()
            .map(|file| file.len())
    };
    let (present, absent): (Vec<&Snapshot>, Vec<&Snapshot>) = manifest
        .snapshots
        .iter()
        .partition(|one| size(one).is_some());
    let mut names: Vec<&str> = present.iter().map(|one| one.engine.as_str()).collect();
    names.sort_by_key(|name| (engine_rank(name).unwrap_or(usize::MAX), *name));
    names.dedup();
    let mut times: Vec<f64> = present.iter().map(|one| one.time).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    // A line of a snapshot has some hundred characters, a packed particle eight at most.
    let bytes = |time: f64| -> u64 {
        let at_time = present.iter().filter(|one| one.time == time);
        at_time.filter_map(|one| size(one)).sum::<u64>() / 8
    };
    let most = (1..=times.len())
        .rev()
        .find(|most| spread(&times, *most).into_iter().map(bytes).sum::<u64>() <= BUDGET);
    let shown = spread(&times, most.unwrap_or(0));
    let mut frames: Vec<Vec<Value>> = Vec::new();
    for time in &shown {
        let at_time = names.iter().map(|name| {
            let found = present
                .iter()
                .find(|one| one.engine == *name && one.time == *time);
            found.map_or(Ok(Value::Null), |one| {
                Ok(pack(&initial::read(&folder.join(&one.file))?))
            })
        });
        frames.push(at_time.collect::<Result<_, ReportError>>()?);
    }
    let data = json!({
        "engines": names.iter().map(|name| engine_title(name)).collect::<Vec<_>>(),
        "times": shown.iter().map(|time| format!("t = {}", number(*time, 4))).collect::<Vec<_>>(),
        "frames": frames,
    });
    Ok(Frames {
        // The text stands inside a script element, which a tag in a name must not close.
        data: if shown.is_empty() {
            String::new()
        } else {
            data.to_string().replace('<', "\\u003c")
        },
        shown: shown.len(),
        available: times.len(),
        missing: absent.iter().map(|one| one.file.clone()).collect(),
    })
}

/// Packs one frame.
fn pack(particles: &StartFile) -> Value {
    let count = particles.positions.len();
    let radius = |i: usize| particles.radii.as_ref().map_or(0.5, |radii| radii[i]);
    let largest = (0..count).map(radius).fold(0.0, f64::max);
    let equal = (0..count).all(|i| radius(i) == largest);
    let (mut places, mut hues, mut radii) = (Vec::new(), Vec::new(), Vec::new());
    for (i, position) in particles.positions.iter().enumerate() {
        for axis in 0..2 {
            let share = (position[axis] / particles.lengths[axis]).rem_euclid(1.0);
            // Rounding up to one is the other end of the period, which is zero.
            let place = ((share * 65536.0).round() as u32 % 65536) as u16;
            places.extend_from_slice(&place.to_le_bytes());
        }
        let velocity = particles.velocities.as_ref().map(|all| all[i]);
        let turn = velocity.map_or(0.0, |v| (v[1].atan2(v[0]) / TAU).rem_euclid(1.0));
        hues.push(((turn * 256.0).round() as u32 % 256) as u8);
        if !equal {
            radii.push((radius(i) / largest * 255.0).round() as u8);
        }
    }
    json!({
        "w": particles.lengths[0], "h": particles.lengths[1], "r": largest,
        "p": STANDARD.encode(places), "v": STANDARD.encode(hues), "s": STANDARD.encode(radii),
    })
}
