//! Damaged checkpoints of exact dynamics are detected, or read and then taken or refused by the
//! engine, never with a panic.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use proptest::test_runner::TestCaseError;
use stosszahl::ed::{DissipationRule, EventDrivenCheckpoint, EventDrivenEngine};
use stosszahl::model::initial::{self, Arrangement};
use stosszahl::model::samples::{EqualDisks, disks};
use stosszahl::model::snapshot::{self, SnapshotError};

use crate::damage::{clear, fuzz};
use crate::support::gas;

const RUN: snapshot::Fingerprint = [3; 32];

/// Returns the files of two checkpoints, with and without contact times.
fn checkpoints(folder: &Path) -> Vec<Vec<u8>> {
    [DissipationRule::Scene, DissipationRule::ContactTime(1e-3)]
        .into_iter()
        .map(|dissipation| {
            let start = gas(Arrangement::Disordered, 6, 0.3, 1);
            let mut engine =
                EventDrivenEngine::<_>::new(disks(0.9), dissipation, start).expect("an engine");
            engine
                .advance(f64::INFINITY, 20, &mut ())
                .expect("collisions");
            let path = folder.join("valid");
            snapshot::write_snapshot(&path, &RUN, &engine.checkpoint()).expect("written");
            fs::read(&path).expect("read")
        })
        .collect()
}

/// Size of the header before the payload \[bytes\]: mark, format, length, fingerprint, hash.
const HEADER: usize = 84;

/// Damage to a checkpoint is always detected: no content is read other than was written.
#[test]
fn damaged_checkpoints() {
    let folder = tempfile::tempdir().expect("a folder");
    let valid = checkpoints(folder.path());
    let path = folder.path().join("checkpoint");
    fuzz(3000, &valid, |bytes| {
        fs::write(&path, bytes).expect("written");
        match snapshot::read_snapshot::<EventDrivenCheckpoint<EqualDisks>>(&path, &RUN) {
            Err(error @ (SnapshotError::Damaged { .. } | SnapshotError::Foreign { .. })) => {
                clear(&error.to_string(), &path)
            }
            Err(error) => Err(TestCaseError::fail(format!("another error: {error}"))),
            Ok(_) => {
                prop_assert!(
                    valid.iter().any(|whole| whole == bytes),
                    "damage was not noticed"
                );
                Ok(())
            }
        }
    });
}

/// Payloads that are wrong under the right hash, as another version might write them, are read or
/// refused; those that are read are taken by the engine or refused.
#[test]
fn wrong_checkpoints() {
    let folder = tempfile::tempdir().expect("a folder");
    let valid: Vec<Vec<u8>> = checkpoints(folder.path())
        .into_iter()
        .map(|whole| whole[HEADER..].to_vec())
        .collect();
    let path = folder.path().join("checkpoint");
    fuzz(3000, &valid, |payload| {
        let mut bytes = b"STOSSZHL".to_vec();
        bytes.extend_from_slice(&1_u32.to_le_bytes());
        bytes.extend_from_slice(&(payload.len() as u64).to_le_bytes());
        bytes.extend_from_slice(&RUN);
        bytes.extend_from_slice(blake3::hash(payload).as_bytes());
        bytes.extend_from_slice(payload);
        fs::write(&path, bytes).expect("written");
        match snapshot::read_snapshot::<EventDrivenCheckpoint<EqualDisks>>(&path, &RUN) {
            Err(error) => clear(&error.to_string(), &path),
            Ok(checkpoint) => {
                // States that the engine does not refuse, see `EventDrivenEngine::new`, are left
                // out.
                let state = &checkpoint.state;
                let positions: Vec<_> = state
                    .bodies
                    .iter()
                    .map(|body| state.domain.wrap(body.position))
                    .collect();
                let finite = positions
                    .iter()
                    .chain([&state.domain.lengths()])
                    .all(|v| v.iter().all(|x| x.is_finite()));
                if finite
                    && initial::first_overlap(&positions, |_| 0.5, &state.domain, 1e-9).is_some()
                {
                    return Ok(());
                }
                for dissipation in [DissipationRule::Scene, DissipationRule::ContactTime(1e-3)] {
                    if let Err(error) =
                        EventDrivenEngine::<_>::new(disks(0.9), dissipation, checkpoint.clone())
                    {
                        prop_assert!(error.to_string().len() > 12, "{error}");
                    }
                }
                Ok(())
            }
        }
    });
}
