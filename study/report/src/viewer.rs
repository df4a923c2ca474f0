//! Particle player of report pages: frames and snapshots, quantised and compressed.
//!
//! Before compression a particle takes six bytes: sixteen bits for each coordinate, eight each for
//! direction and speed. One more holds the radius if radii differ, and one the last collision if it
//! is known. If consecutive frames hold the same particles, differences of positions are stored,
//! high and low bytes separately, which `deflate` compresses better. If all frames together are too
//! large, each but the last is cut to a fair sample. A plain script (`viewer.js`) draws them,
//! because a library would be larger than the particles.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use stosszahl_model::initial::{self, StartFile};
use stosszahl_results::frames::{Dot, FASTEST, ParticleFrame, STEPS};
use stosszahl_results::{Manifest, engine_rank, engine_title, frames};

use crate::ReportError;
use crate::archive::deflated;
use crate::words::{number, spread};

/// JavaScript of the particle player.
pub(crate) const SCRIPT: &str = include_str!("viewer.js");
/// Size limits of the frames before compression \[bytes\]: of the last frames of the engines, and
/// of all other frames.
const BUDGET: [usize; 2] = [2_100_000, 2_000_000];
/// Largest number of times with particle frames on a page; of more, an even selection is shown.
const FRAMES: usize = 120;

/// Data of the particle player, as embedded in a page.
pub(crate) struct Player {
    /// JSON data for the script of the player; empty without frames.
    pub data: String,
    /// Number of sample times whose frames are on the page.
    pub shown: usize,
    /// Number of sample times for which there are frames.
    pub available: usize,
    /// True if frames show a sample of the particles, not all.
    pub sampled: bool,
    /// Names of frame and snapshot files that are missing in the folder.
    pub missing: Vec<String>,
}

/// Sequence of particle frames of one engine.
struct Reel {
    engine: String,
    frames: Vec<ParticleFrame>,
}

/// Reads the frames and snapshots of a results folder, and packs as many as fit into a page.
pub(crate) fn player(folder: &Path, manifest: &Manifest) -> Result<Player, ReportError> {
    let (mut reels, missing) = reels(folder, manifest)?;
    let mut times: Vec<f64> = (reels.iter())
        .flat_map(|reel| reel.frames.iter().map(|frame| frame.time))
        .collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let available = times.len();
    let times = spread(&times, FRAMES);
    let last = times.last().copied().unwrap_or(0.0);
    let mut sampled = false;
    for reel in &mut reels {
        reel.frames.retain(|frame| times.contains(&frame.time));
    }
    let many = (times.len().max(2) - 1) * reels.len().max(1);
    let each = [BUDGET[0] / reels.len().max(1), BUDGET[1] / many];
    for frame in reels.iter_mut().flat_map(|reel| &mut reel.frames) {
        let bytes = 6 + [&frame.size, &frame.met]
            .map(|plane| usize::from(!plane.is_empty()))
            .iter()
            .sum::<usize>();
        let most = each[usize::from(frame.time < last)] / bytes;
        if frame.len() > most {
            *frame = frame.first(most);
        }
        sampled |= frame.share > 1.0;
    }
    let mut packed = Packed::default();
    let all: Vec<Vec<Value>> = (reels.iter())
        .map(|reel| packed.reel(reel, &times))
        .collect();
    let data = json!({
        "engines": reels.iter().map(|reel| engine_title(&reel.engine)).collect::<Vec<_>>(),
        "times": times.iter().map(|time| format!("t = {}", number(*time, 4))).collect::<Vec<_>>(),
        "frames": all, "fastest": FASTEST, "steps": STEPS, "obstacles": obstacles(manifest), "packed": packed.compressed_base64(),
    });
    Ok(Player {
        data: if times.is_empty() {
            String::new()
        } else {
            crate::page::data(&data).into_string()
        },
        shown: times.len(),
        available,
        sampled,
        missing,
    })
}

/// Reads the frames of all engines of a results folder, in the order of engines; also returns the
/// names of missing files.
fn reels(folder: &Path, manifest: &Manifest) -> Result<(Vec<Reel>, Vec<String>), ReportError> {
    let (mut reels, mut missing): (Vec<Reel>, Vec<String>) = (Vec::new(), Vec::new());
    for entry in &manifest.frames {
        let path = folder.join(&entry.file);
        if path.exists() {
            reels.push(Reel {
                engine: entry.engine.clone(),
                frames: frames::read_frames(&path)?,
            });
        } else {
            missing.push(entry.file.clone());
        }
    }
    // Snapshots are shown where their engine has no frame.
    let framed: Vec<String> = manifest
        .frames
        .iter()
        .map(|one| one.engine.clone())
        .collect();
    for snapshot in manifest.snapshots.iter().filter(|one| one.is_shown()) {
        let path = folder.join(&snapshot.file);
        if !path.exists() {
            missing.push(snapshot.file.clone());
        } else if !framed.contains(&snapshot.engine) {
            let frame = frame_of(&initial::read_start_file(&path)?, snapshot.time);
            match reels.iter_mut().find(|reel| reel.engine == snapshot.engine) {
                Some(reel) => reel.frames.push(frame),
                None => reels.push(Reel {
                    engine: snapshot.engine.clone(),
                    frames: vec![frame],
                }),
            }
        }
    }
    reels.sort_by_key(|reel| {
        (
            engine_rank(&reel.engine).unwrap_or(usize::MAX),
            reel.engine.clone(),
        )
    });
    Ok((reels, missing))
}

/// Converts a snapshot to a frame with all its particles.
fn frame_of(particles: &StartFile, time: f64) -> ParticleFrame {
    let positions = particles.positions.iter().flatten();
    let dots: Vec<Dot> = (positions.enumerate())
        .map(|(i, at)| Dot {
            position: [at[0], at[1]],
            velocity: (particles.velocities.as_ref())
                .map_or([0.0; 2], |all| [all[i][0], all[i][1]]),
            radius: particles.radii.as_ref().map_or(0.5, |radii| radii[i]),
            weight: 1.0,
            met: None,
        })
        .collect();
    let [width, height, _] = particles.lengths.unwrap_or_default();
    let [x, y, _] = particles.periodic.unwrap_or([true; 3]);
    ParticleFrame::new(time, [width, height], [x, y], &dots, usize::MAX)
}

/// Returns the obstacles of the case as it was run, as JSON: disks, polylines and polygons.
pub(crate) fn obstacles(manifest: &Manifest) -> Vec<Value> {
    let listed = manifest.case.get("obstacle").and_then(Value::as_array);
    let shapes = listed.into_iter().flatten().map(|one| {
        json!({ "circle": one.get("circle"), "polyline": one.get("polyline"), "polygon": one.get("polygon") })
    });
    shapes.collect()
}

/// Quantised particle data of all frames, one after the other, before compression.
#[derive(Default)]
struct Packed(Vec<u8>);

impl Packed {
    /// Packs the frames of one engine and returns a JSON description of each; times without a frame
    /// are null.
    fn reel(&mut self, reel: &Reel, times: &[f64]) -> Vec<Value> {
        let mut before: Option<&ParticleFrame> = None;
        let mut described = Vec::new();
        for time in times {
            let Some(frame) = reel.frames.iter().find(|frame| frame.time == *time) else {
                described.push(Value::Null);
                continue;
            };
            let base = before.filter(|before| before.len() == frame.len());
            self.pack_coordinates(&frame.x, base.map(|base| &base.x));
            self.pack_coordinates(&frame.y, base.map(|base| &base.y));
            for plane in [&frame.direction, &frame.pace, &frame.size, &frame.met] {
                self.0.extend_from_slice(plane);
            }
            described.push(json!({
                "n": frame.len(), "after": base.is_some(), "sized": !frame.size.is_empty(), "told": !frame.met.is_empty(), "sides": frame.sides,
                "periodic": frame.periodic, "radius": frame.radius, "share": frame.share, "all": frame.particles.round(),
            }));
            before = Some(frame);
        }
        described
    }

    /// Packs the coordinates of a frame, or their changes from the frame before, high bytes first.
    fn pack_coordinates(&mut self, now: &[u8], before: Option<&Vec<u8>>) {
        let word = |bytes: &[u8], i: usize| u16::from_le_bytes([bytes[2 * i], bytes[2 * i + 1]]);
        let changed: Vec<u16> = (0..now.len() / 2)
            .map(|i| word(now, i).wrapping_sub(before.map_or(0, |before| word(before, i))))
            .collect();
        self.0
            .extend(changed.iter().map(|word| word.to_le_bytes()[1]));
        self.0
            .extend(changed.iter().map(|word| word.to_le_bytes()[0]));
    }

    /// Compresses the packed bytes by `deflate` and returns them as Base64 text.
    fn compressed_base64(&self) -> String {
        STANDARD.encode(deflated(&self.0))
    }
}
